# SPDX-License-Identifier: Apache-2.0
"""How names and values of a definition are written in C++."""
import json
import math

from rosidl_pycommon import convert_camel_case_to_lower_case_underscore as snake_case

from model import ARRAY, NUMBERS, SINGLE

_KEYWORDS = frozenset('''
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class
compl concept const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype
default delete do double dynamic_cast else enum explicit export extern false float for friend goto if inline
int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
reinterpret_cast requires return short signed sizeof static static_assert static_cast struct switch template
this thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t
while xor xor_eq'''.split())
# Macros of the standard headers that could meet a name, and what the struct itself has.
_TAKEN = frozenset('''NULL EOF NAN INFINITY HUGE_VAL BUFSIZ RAND_MAX TRUE FALSE errno stdin stdout stderr assert
message_type service_type action_type'''.split())

_NUMBER_TYPES = {'bool': 'bool', 'byte': 'std::uint8_t', 'char': 'std::uint8_t', 'int8': 'std::int8_t',
                 'uint8': 'std::uint8_t', 'int16': 'std::int16_t', 'uint16': 'std::uint16_t', 'int32': 'std::int32_t',
                 'uint32': 'std::uint32_t', 'int64': 'std::int64_t', 'uint64': 'std::uint64_t', 'float32': 'float',
                 'float64': 'double', 'string': 'std::string', 'wstring': 'std::u16string'}


def member_name(name):
    """The C++ member of a field or constant: C++'s own words get a trailing underscore."""
    return name + '_' if name in _KEYWORDS or name in _TAKEN else name


def cpp_type_name(name):
    """'pkg/msg/Name' -> '::pkg::msg::Name'"""
    return '::' + name.replace('/', '::')


def header_path(package, kind, stem):
    return f'{package}/{kind}/{snake_case(stem)}.hpp'


def value_type(type_):
    return cpp_type_name(type_.message) if type_.kind == 'message' else _NUMBER_TYPES[type_.kind]


def field_type(type_):
    value = value_type(type_)
    if type_.shape == SINGLE:
        return value
    if type_.shape == ARRAY:
        return f'std::array<{value}, {type_.bound}>'
    return f'nacelle::Buffer<{value}>' if type_.kind in NUMBERS else f'std::vector<{value}>'


def string_literal(text):
    """A C string literal of UTF-8; long texts are split at their lines."""
    pieces, line = [], ''
    for byte in text.encode('utf-8'):
        character = chr(byte)
        if character == '\n':
            pieces.append(line + '\\n')
            line = ''
        elif character in '"\\':
            line += '\\' + character
        elif 32 <= byte < 127 and character != '?':  # '?' could begin a trigraph.
            line += character
        else:
            line += f'\\{byte:03o}'
    if line or not pieces:
        pieces.append(line)
    return '\n    '.join(f'"{piece}"' for piece in pieces)


def _wide_literal(text):
    units = text.encode('utf-16-le')
    return 'u"' + ''.join(f'\\x{units[i + 1]:02x}{units[i]:02x}" u"' for i in range(0, len(units), 2)) + '"'


def literal(kind, value):
    if kind == 'bool':
        return 'true' if value else 'false'
    if kind in ('float32', 'float64'):
        type_ = _NUMBER_TYPES[kind]
        if math.isnan(value):
            return f'std::numeric_limits<{type_}>::quiet_NaN()'
        if math.isinf(value):
            return ('-' if value < 0 else '') + f'std::numeric_limits<{type_}>::infinity()'
        return repr(float(value)) + ('F' if kind == 'float32' else '')
    if kind == 'string':
        return string_literal(value)
    if kind == 'wstring':
        return _wide_literal(value)
    if kind == 'int64' and value == -2**63:
        return '(-9223372036854775807LL - 1)'
    return str(value) + {'int64': 'LL', 'uint64': 'ULL', 'uint32': 'U'}.get(kind, '')


def initializer(field):
    """What stands behind the member: its default, or zero for numbers."""
    type_ = field.type
    if field.default is not None:
        values = field.default if isinstance(field.default, list) else [field.default]
        texts = [f'{value_type(type_)}({literal(type_.kind, one)})' if type_.kind in ('string', 'wstring')
                 else literal(type_.kind, one) for one in values]
        return '{' + ', '.join(texts) + '}'
    if type_.kind in NUMBERS and not type_.is_sequence:
        return '{}'
    return ''


def json_default(value):
    if value is None:
        return None

    def one(item):
        if isinstance(item, float) and not math.isfinite(item):
            return 'NaN' if math.isnan(item) else 'Infinity' if item > 0 else '-Infinity'
        return item
    return json.dumps([one(item) for item in value] if isinstance(value, list) else one(value), ensure_ascii=False)
