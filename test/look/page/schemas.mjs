// SPDX-License-Identifier: Apache-2.0
// Makes ros2msg schemas of the repository's definitions, as the server does.
import fs from 'node:fs';
import path from 'node:path';
import {fileURLToPath} from 'node:url';

import {parseSchema} from '../../../components/look/page/ros2msg.js';

export const ROOT = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../../..');
const DEFINITIONS = path.join(ROOT, 'interfaces/msgs/definitions');
const PLAIN = /^(bool|byte|char|u?int(8|16|32|64)|float(32|64)|w?string)$/;

function textOf(type) {
  const [pkg, kind, name] = type.split('/');
  if (kind === 'msg') return fs.readFileSync(path.join(DEFINITIONS, pkg, 'msg', `${name}.msg`), 'utf8');
  const [, service, part] = /^(.*)_(Request|Response)$/.exec(name);
  const text = fs.readFileSync(path.join(DEFINITIONS, pkg, 'srv', `${service}.srv`), 'utf8');
  return text.split(/^---$/m)[part === 'Request' ? 0 : 1];
}

/** Returns the concatenated texts of a type, named pkg/msg/Type or pkg/srv/Type_Request. */
export function schemaText(type) {
  const parts = [textOf(type)];
  const seen = new Set();
  const visit = (text, pkg) => {
    for (const line of text.split('\n')) {
      const word = /^\s*([A-Za-z]\w*(?:\/\w+)*)/.exec(line.replace(/#.*/, ''))?.[1];
      if (!word || PLAIN.test(word)) continue;
      const names = word.split('/');
      const full = names.length === 1 ? `${pkg}/${word}` : `${names[0]}/${names.at(-1)}`;
      if (seen.has(full)) continue;
      seen.add(full);
      const inner = textOf(full.replace('/', '/msg/'));
      parts.push(`${'='.repeat(80)}\nMSG: ${full}\n${inner}`);
      visit(inner, full.split('/')[0]);
    }
  };
  visit(parts[0], type.split('/')[0]);
  return parts.join('\n');
}

export function schemaOf(type) {
  return parseSchema(type, schemaText(type));
}
