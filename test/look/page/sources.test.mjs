// SPDX-License-Identifier: Apache-2.0
// What no module of the page may do, and that each of them is whole.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import test from 'node:test';

import {ROOT} from './schemas.mjs';

const PAGE = path.join(ROOT, 'components/look/page');
const files = ['', 'panels'].flatMap((folder) =>
  fs
    .readdirSync(path.join(PAGE, folder), {withFileTypes: true})
    .filter((entry) => entry.isFile())
    .map(({name}) => path.join(folder, name)),
);
const modules = files.filter((name) => name.endsWith('.js'));
const textOf = (name) => fs.readFileSync(path.join(PAGE, name), 'utf8');

test('there are modules', () => assert.ok(modules.length > 30));

for (const name of modules) {
  test(`${name} is whole, and takes the robot's words as text`, () => {
    const text = textOf(name);
    const checked = spawnSync(process.execPath, ['--check', path.join(PAGE, name)], {encoding: 'utf8'});
    assert.equal(checked.status, 0, checked.stderr);
    assert.doesNotMatch(text, /innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function/);
    for (const [, what, from] of text.matchAll(/^import (.*) from '(.*)';$/gm)) {
      const target = path.join(path.dirname(name), from);
      assert.ok(files.includes(target), `${from} is not there`);
      for (const word of what.replace(/[{}\s]/g, '').split(',')) assert.match(textOf(target), new RegExp(`^export .*\\b${word}\\b`, 'm'));
    }
  });
}

test('the page has nothing inline and nothing from elsewhere, as its Content-Security-Policy asks', () => {
  const html = textOf('index.html');
  assert.doesNotMatch(html, /\sstyle=|<style|\son\w+=|<script(?![^>]*\ssrc=)/);
  for (const [, target] of html.matchAll(/(?:src|href)="([^"]*)"/g)) assert.ok(target === 'data:,' || files.includes(target), target);
  for (const name of files) assert.doesNotMatch(textOf(name), /https?:\/\/(?!www\.w3\.org\/2000\/svg)/, name);
});
