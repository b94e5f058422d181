# SPDX-License-Identifier: Apache-2.0
"""From fields to encoding steps: nested messages are flattened, neighbouring numbers of one width become one step.

Whether two numbers are neighbours in memory is computed here with the rules of the 64-bit Linux ABIs; the generated
source asserts it again for the compiler at hand.
"""
from dataclasses import dataclass

from cpp_names import member_name
from model import ARRAY, NUMBERS, SINGLE, TEXTS, DefinitionError

WIDTHS = {'bool': 1, 'byte': 1, 'char': 1, 'int8': 1, 'uint8': 1, 'int16': 2, 'uint16': 2, 'int32': 4, 'uint32': 4,
          'int64': 8, 'uint64': 8, 'float32': 4, 'float64': 8}
# std::string, std::u16string, std::vector, nacelle::Buffer: only that they are aligned to 8 and multiples of 8 matters.
_TEXT_SIZE, _VECTOR_SIZE, _BUFFER_SIZE = 32, 24, 48
# A text of this length still fits into std::string itself; UTF-16 texts hold half as many.
_INLINE_TEXT = {'string': 15, 'wstring': 7}
_LEAST_COUNT = 4


@dataclass
class Step:
    kind: str                # the StepKind enumerator
    path: str                # C++ member path from the message: 'pose.pose.position.x'
    offset: int
    width: int = 0
    count: int = 1
    bound: int = 0
    text_bound: int = 0
    message: str = ''
    access: str = ''         # kind of the elements of a sequence
    joined: tuple = ()       # (path, numbers before it) of each member that was merged into this step


def _round_up(value, to):
    return (value + to - 1) // to * to


class Layouts:
    def __init__(self, library):
        self._library = library
        self._known = {}
        self._open = []

    def _facts(self, message):
        """(size, alignment, offsets, least encoded size, holds buffers, defaults allocate) of a message."""
        if message.name in self._known:
            return self._known[message.name]
        if message.name in self._open:
            raise DefinitionError(f'{message.name} contains itself: {" -> ".join(self._open)} -> {message.name}')
        self._open.append(message.name)
        at, alignment, offsets, least, buffers, allocates = 0, 1, [], 0, False, False
        for field in message.wire_fields():
            size, align, element_least, has_buffers, default_allocates = self._field_facts(message, field)
            at = _round_up(at, align)
            offsets.append(at)
            at += size
            alignment = max(alignment, align)
            least += element_least
            buffers |= has_buffers
            allocates |= default_allocates
        self._open.pop()
        self._known[message.name] = (_round_up(at, alignment), alignment, offsets, least, buffers, allocates)
        return self._known[message.name]

    def _field_facts(self, message, field):
        type_ = field.type
        if type_.is_sequence:
            if type_.kind == 'message':
                nested = self._facts(self._library.message(type_.message, message.name))
                return _VECTOR_SIZE, 8, _LEAST_COUNT, nested[4], False
            numbers = type_.kind in NUMBERS
            return _BUFFER_SIZE if numbers else _VECTOR_SIZE, 8, _LEAST_COUNT, numbers, bool(field.default)
        count = type_.bound if type_.shape == ARRAY else 1
        if type_.kind == 'message':
            size, align, _, least, buffers, allocates = self._facts(self._library.message(type_.message, message.name))
            return size * count, align, least * count, buffers, allocates
        if type_.kind in TEXTS:
            defaults = field.default if isinstance(field.default, list) else [field.default or '']
            long_default = any(len(one.encode('utf-8')) > _INLINE_TEXT[type_.kind] for one in defaults)
            return _TEXT_SIZE * count, 8, _LEAST_COUNT * count, False, long_default
        width = WIDTHS[type_.kind]
        return width * count, width, width * count, False, False

    def least_encoded_size(self, message):
        return self._facts(message)[3]

    def holds_buffers(self, message):
        return self._facts(message)[4]

    def defaults_allocate(self, message):
        return self._facts(message)[5]

    def steps(self, message):
        flat = []
        self._flatten(message, '', 0, flat)
        merged = []
        for step in flat:
            last = merged[-1] if merged else None
            if (last and step.kind == last.kind and step.kind in ('Numbers', 'Bools') and step.width == last.width
                    and step.offset == last.offset + last.count * max(1, last.width)):
                last.joined += ((step.path, last.count),)
                last.count += step.count
            else:
                merged.append(step)
        return merged

    def _flatten(self, message, prefix, base, steps):
        offsets = self._facts(message)[2]
        for field, offset in zip(message.wire_fields(), offsets):
            path, at, type_ = prefix + member_name(field.name), base + offset, field.type
            count = type_.bound if type_.shape == ARRAY else 1
            if type_.is_sequence:
                steps.append(self._sequence(type_, path, at))
            elif type_.kind == 'message' and type_.shape == SINGLE:
                self._flatten(self._library.message(type_.message, message.name), path + '.', at, steps)
            elif type_.kind == 'message':
                steps.append(Step('Messages', path, at, count=count, message=type_.message))
            elif type_.kind in TEXTS:
                steps.append(Step({'string': 'Texts', 'wstring': 'WideTexts'}[type_.kind], path, at, count=count,
                                  text_bound=type_.text_bound))
            elif type_.kind == 'bool':
                steps.append(Step('Bools', path, at, width=1, count=count))
            else:
                steps.append(Step('Numbers', path, at, width=WIDTHS[type_.kind], count=count))

    @staticmethod
    def _sequence(type_, path, at):
        kind = {'message': 'MessageSequence', 'string': 'TextSequence', 'wstring': 'WideTextSequence',
                'bool': 'BoolSequence'}.get(type_.kind, 'NumberSequence')
        return Step(kind, path, at, width=WIDTHS.get(type_.kind, 0), bound=type_.bound, text_bound=type_.text_bound,
                    message=type_.message, access=type_.kind)
