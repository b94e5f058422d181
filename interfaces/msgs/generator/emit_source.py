# SPDX-License-Identifier: Apache-2.0
"""The sources of a package: tables of fields and encoding steps, and the functions that answer them."""
import cpp_names as cpp
from definition_text import DefinitionTexts
from layout import Layouts
from model import NUMBERS, SINGLE
from type_hash import Hasher

_KINDS = {'bool': 'Bool', 'byte': 'Byte', 'char': 'Char', 'int8': 'Int8', 'uint8': 'Uint8', 'int16': 'Int16',
          'uint16': 'Uint16', 'int32': 'Int32', 'uint32': 'Uint32', 'int64': 'Int64', 'uint64': 'Uint64',
          'float32': 'Float32', 'float64': 'Float64', 'string': 'String', 'wstring': 'WString', 'message': 'Message'}
_SHAPES = {SINGLE: 'Single', 'array': 'Array', 'bounded': 'BoundedSequence', 'sequence': 'Sequence'}
_ACCESS = {**{kind: f'&access::k{_KINDS[kind]}' for kind in (*NUMBERS, 'string', 'wstring')},
           'byte': '&access::kUint8', 'char': '&access::kUint8'}


def _function(name, what='message_type'):
    return f'&{cpp.cpp_type_name(name)}::{what}'


class SourceEmitter:
    def __init__(self, library):
        self._library = library
        self._layouts = Layouts(library)
        self._hasher = Hasher(library)
        self._texts = DefinitionTexts(library)

    def source(self, package, definitions, table_of=()):
        """A translation unit that defines the types of `definitions`, with the library entry if `table_of` is set."""
        lines = ['// SPDX-License-Identifier: Apache-2.0', f'// Generated from {package}.',
                 '#include "nacelle/msgs/type_support.hpp"', '', '#include <cstddef>', '']
        lines += [f'#include "{cpp.header_path(package, one.kind, one.stem)}"' for one in table_of or definitions]
        lines += ['', 'namespace nacelle::msgs {', 'namespace {']
        functions = []
        for definition in definitions:
            for message in definition.messages():
                lines += self._tables(message)
                functions += self._message_function(message)
            for service in definition.services():
                functions += self._service_function(service)
            for action in definition.actions():
                functions += self._action_function(action)
        if table_of:
            lines += self._package_table(package, table_of)
            functions += ['extern "C" [[gnu::visibility("default")]] const nacelle::msgs::PackageTable* '
                          'nacelle_message_package_v1();',
                          'extern "C" const nacelle::msgs::PackageTable* nacelle_message_package_v1() {',
                          '  return &nacelle::msgs::kTable;', '}', '']
        lines += ['}  // namespace', '}  // namespace nacelle::msgs', '']
        return '\n'.join(lines + functions)

    @staticmethod
    def _package_table(package, definitions):
        lists = {
            'messages': ('MessageTypeFunction',
                         [_function(one.name) for each in definitions for one in each.messages()]),
            'services': ('ServiceTypeFunction',
                         [_function(one.name, 'service_type') for each in definitions for one in each.services()]),
            'actions': ('ActionTypeFunction',
                        [_function(one.name, 'action_type') for each in definitions for one in each.actions()])}
        lines, spans = [''], []
        for name, (type_, functions) in lists.items():
            if functions:
                lines.append(f'constexpr {type_} k_{name}[] = {{\n    ' + ',\n    '.join(functions) + '};')
            spans.append(f'k_{name}' if functions else '{}')
        return lines + [f'constexpr PackageTable kTable{{"{package}", {", ".join(spans)}}};', '']

    def _access(self, kind, message, named_by):
        if kind != 'message':
            return _ACCESS[kind]
        nested = self._library.message(message, named_by)
        allocates = 'true' if self._layouts.defaults_allocate(nested) else 'false'
        return f'&detail::kVectorOf<{cpp.cpp_type_name(message)}, {allocates}>'

    def _field(self, message, field):
        type_ = field.type
        default = cpp.json_default(field.default)
        access = self._access(type_.kind, type_.message, message.name) if type_.is_sequence else 'nullptr'
        return (f'    {{"{field.name}", Kind::{_KINDS[type_.kind]}, Shape::{_SHAPES[type_.shape]}, {type_.bound}U, '
                f'{type_.text_bound}U, offsetof(T, {cpp.member_name(field.name)}), '
                f'{_function(type_.message) if type_.message else "nullptr"}, {access}, '
                f'{cpp.string_literal(default) if default is not None else "nullptr"}}},')

    def _step(self, message, step):
        access = self._access(step.access, step.message, message.name) if step.access else 'nullptr'
        return (f'    {{StepKind::{step.kind}, {step.width}, offsetof(T, {step.path}), {step.count}U, {step.bound}U, '
                f'{step.text_bound}U, {_function(step.message) if step.message else "nullptr"}, {access}}},')

    def _tables(self, message):
        steps = self._layouts.steps(message)
        lines = ['', f'struct Tables_{_identifier(message.name)} {{', f'  using T = {cpp.cpp_type_name(message.name)};']
        if message.fields:
            lines += ['  static constexpr Field kFields[] = {', *(self._field(message, one) for one in message.fields),
                      '  };']
        lines += ['  static constexpr Step kSteps[] = {', *(self._step(message, one) for one in steps), '  };']
        for step in steps:
            if step.joined:
                conditions = ' &&\n                '.join(
                    f'offsetof(T, {path}) == offsetof(T, {step.path}) + {before * step.width}U'
                    for path, before in step.joined)
                lines.append(f'  static_assert({conditions});')
        # Decoding n bytes may allocate 64 n: a vector that grows takes twice its elements at most.
        lines += [f'  static_assert(sizeof(T) <= 28U * {self._layouts.least_encoded_size(message)}U);', '};']
        return lines

    def _message_function(self, message):
        type_ = cpp.cpp_type_name(message.name)
        tables = f'nacelle::msgs::Tables_{_identifier(message.name)}'
        package, kind, stem = message.name.split('/')
        text = self._texts.of(message.text, [message])
        return [f'const nacelle::msgs::MessageType& {type_[2:]}::message_type() {{',
                f'  static constexpr nacelle::msgs::MessageType kType = '
                f'nacelle::msgs::detail::make_message_type<{type_}>(',
                f'      {{"{message.name}", "{package}::{kind}::dds_::{stem}_",',
                f'       "{self._hasher.message(message)}",',
                f'    {cpp.string_literal(text)}}},',
                f'      {tables + "::kFields" if message.fields else "{}"}, {tables}::kSteps, '
                f'{self._layouts.least_encoded_size(message)}U, '
                f'{"true" if self._layouts.holds_buffers(message) else "false"});',
                '  return kType;', '}', '']

    def _service_function(self, service):
        functions = ', '.join(_function(part.name) for part in service.messages())
        text = self._texts.of(service.text, [service.request, service.response])
        return [f'const nacelle::msgs::ServiceType& {cpp.cpp_type_name(service.name)[2:]}::service_type() {{',
                f'  static constexpr nacelle::msgs::ServiceType kType{{"{service.name}",',
                f'      "{self._hasher.service(service)}",', f'    {cpp.string_literal(text)},',
                f'      {functions}}};', '  return kType;', '}', '']

    def _action_function(self, action):
        parts = [_function(part.name) for part in (action.goal, action.result, action.feedback)]
        parts += [_function(part.name, 'service_type') for part in (action.send_goal, action.get_result)]
        parts.append(_function(action.feedback_message.name))
        text = self._texts.of(action.text, [action.goal, action.result, action.feedback])
        return [f'const nacelle::msgs::ActionType& {cpp.cpp_type_name(action.name)[2:]}::action_type() {{',
                f'  static constexpr nacelle::msgs::ActionType kType{{"{action.name}",',
                f'      "{self._hasher.action(action)}",', f'    {cpp.string_literal(text)},',
                f'      {", ".join(parts)}}};', '  return kType;', '}', '']


def _identifier(name):
    return name.replace('/', '_')
