# SPDX-License-Identifier: Apache-2.0
"""Reads .msg, .srv and .action files with ROS 2's own parser (Debian's python3-rosidl).

The parser for these three formats is rosidl_adapter.parser. ROS 2's build goes on from there to an .idl text and parses
that again with rosidl_parser; that detour is left out: it adds nothing to what a .msg says, takes five seconds for the
packages here, loses the sign of a default of -inf, and fails on a comment that looks like a bad escape (C:\\users).
What the detour derives (an action's services, the texts' escapes) is in this file, and what it never had (_Event).
"""
import contextlib
import io
import pathlib
import re
from dataclasses import dataclass

from rosidl_adapter import parser as ros_parser

from model import (ARRAY, BOUNDED, SEQUENCE, SINGLE, TEXTS, Action, Constant, Definition, DefinitionError, Field,
                   FieldType, Message, Service)

KINDS = ('msg', 'srv', 'action')
EVENT_INFO = 'service_msgs/msg/ServiceEventInfo'
GOAL_ID = 'unique_identifier_msgs/msg/UUID'
TIME = 'builtin_interfaces/msg/Time'


# The packages of the messages that ROS 2 adds to services and actions.
_USED_BY_KIND = {'srv': {'service_msgs'},
                 'action': {'action_msgs', 'service_msgs', 'unique_identifier_msgs', 'builtin_interfaces'}}


def find(directory):
    """The definitions of a package folder as (kind, stem, path), sorted."""
    found = []
    for kind in KINDS:
        found += [(kind, path.stem, path) for path in sorted((directory / kind).glob('*.' + kind))]
    return found


def used_packages(directory):
    """The packages whose messages a package folder names, itself not included; read without parsing."""
    used = set()
    for kind, _, path in find(directory):
        used |= _USED_BY_KIND.get(kind, set())
        for line in path.read_text(encoding='utf-8').splitlines():
            word = re.match(r'\s*([a-z][a-z0-9_]*)/[A-Z]', line)
            if word:
                used.add(word.group(1))
            elif re.match(r'\s*Header\s', line):
                used.add('std_msgs')
    return used - {directory.name}


def _text_value(value):
    # A default text passes through IDL in ROS 2, where its escapes (\n, \t, \u00b0) are resolved.
    try:
        return value.encode('utf-8').decode('unicode_escape').encode('latin-1').decode('utf-8')
    except (UnicodeDecodeError, UnicodeEncodeError):
        return value


def _value(kind, value):
    if value is None:
        return None
    if isinstance(value, list):
        return [_value(kind, one) for one in value]
    return _text_value(value) if kind in TEXTS else value


def _field(source, spec):
    kind = spec.type.type if spec.type.is_primitive_type() else 'message'
    if kind in ('time', 'duration'):
        raise DefinitionError(f"'{kind} {spec.name}' is ROS 1: use builtin_interfaces/{kind.capitalize()}")
    message = '' if kind != 'message' else f'{spec.type.pkg_name}/msg/{spec.type.type}'
    if message == f'{source.package}/msg/Header' and not source.package_has_header():
        message = 'std_msgs/msg/Header'  # ROS's oldest shorthand.
    shape, bound = SINGLE, 0
    if spec.type.is_array:
        bound = spec.type.array_size or 0
        shape = SEQUENCE if not bound else BOUNDED if spec.type.is_upper_bound else ARRAY
    return Field(spec.name, FieldType(kind, message, shape, bound, spec.type.string_upper_bound or 0),
                 _value(kind, spec.default_value))


def _message(source, stem, text):
    spec = ros_parser.parse_message_string(source.package, stem, text)
    return Message(f'{source.package}/{source.kind}/{stem}', text, [_field(source, one) for one in spec.fields],
                   [Constant(one.name, one.type, _value(one.type, one.value)) for one in spec.constants])


def _derived(name, members):
    """A message that ROS 2 derives; members are (type as written, FieldType, name)."""
    text = ''.join(f'{written} {member}\n' for written, _, member in members)
    return Message(name, text, [Field(member, type_) for _, type_, member in members])


def _event(service):
    package, kind, stem = service.split('/')
    parts = [(f'{stem}_{part}[<=1]', FieldType('message', f'{service}_{part}', BOUNDED, 1), part.lower())
             for part in ('Request', 'Response')]
    return _derived(f'{service}_Event', [('service_msgs/ServiceEventInfo', FieldType('message', EVENT_INFO), 'info'),
                                         *parts])


def _parts(text, count, path):
    parts = [[]]
    for line in text.splitlines():
        if line.rstrip() == '---':
            parts.append([])
        else:
            parts[-1].append(line)
    if len(parts) != count:
        raise DefinitionError(f'{path}: {len(parts) - 1} lines "---" where there must be {count - 1}')
    return ['\n'.join(lines).strip('\n') + '\n' for lines in parts]


def _service(source, text):
    request, response = _parts(text, 2, source.path)
    return Service(source.name, text, _message(source, source.stem + '_Request', request),
                   _message(source, source.stem + '_Response', response), _event(source.name))


def _action(source, text):
    name, stem = source.name, source.stem
    goal, result, feedback = (_message(source, f'{stem}_{suffix}', part) for suffix, part in zip(
        ('Goal', 'Result', 'Feedback'), _parts(text, 3, source.path)))

    def part(suffix):
        return (f'{stem}_{suffix}', FieldType('message', f'{name}_{suffix}'), suffix.lower())

    goal_id = ('unique_identifier_msgs/UUID', FieldType('message', GOAL_ID), 'goal_id')

    def service(suffix, request, response):
        full = f'{name}_{suffix}'
        made = (_derived(full + '_Request', request), _derived(full + '_Response', response), _event(full))
        return Service(full, made[0].text + '---\n' + made[1].text, *made)

    send_goal = service('SendGoal', [goal_id, part('Goal')],
                        [('bool', FieldType('bool'), 'accepted'),
                         ('builtin_interfaces/Time', FieldType('message', TIME), 'stamp')])
    get_result = service('GetResult', [goal_id], [('int8', FieldType('int8'), 'status'), part('Result')])
    return Action(name, text, goal, result, feedback, send_goal, get_result,
                  _derived(name + '_FeedbackMessage', [goal_id, part('Feedback')]))


@dataclass(frozen=True)
class _Source:
    """The file that is being read."""
    package: str
    kind: str
    stem: str
    path: pathlib.Path

    @property
    def name(self):
        return f'{self.package}/{self.kind}/{self.stem}'

    def package_has_header(self):
        return (self.path.parent.parent / 'msg' / 'Header.msg').is_file()


def parse(package, kind, stem, path):
    """Reads one file. Errors: DefinitionError that names it."""
    source = _Source(package, kind, stem, path)
    text = path.read_text(encoding='utf-8')
    said = io.StringIO()
    try:
        # The parser tells details on stderr and then raises less.
        with contextlib.redirect_stderr(said):
            content = {'msg': lambda: _message(source, stem, text), 'srv': lambda: _service(source, text),
                       'action': lambda: _action(source, text)}[kind]()
    except DefinitionError as error:
        raise DefinitionError(str(error) if str(path) in str(error) else f'{path}: {error}') from None
    except Exception as error:  # The parser's exceptions have no common base.
        raise DefinitionError(f'{path}: {said.getvalue().strip() or error}') from None
    return Definition(package, kind, stem, content)


class Library:
    """All packages that a package may name; files are read when they are asked for."""

    def __init__(self, directories):
        self._directories = directories
        self._parsed = {}

    def package(self, name):
        """Every definition of a package."""
        found = find(self._directories[name])
        return [self._definition(name, kind, stem, path) for kind, stem, path in found]

    def message(self, name, named_by):
        """A message by its full name. Errors: DefinitionError that says who names it."""
        package, kind, stem = name.split('/')
        if package not in self._directories:
            raise DefinitionError(f"{named_by}: the package '{package}' of {name} is unknown; name it in DEPENDS")
        path = self._directories[package] / kind / f'{stem}.{kind}'
        if kind != 'msg':  # A derived part: it lives in the file of its service or action.
            path = self._directories[package] / kind / f'{stem.split("_")[0]}.{kind}'
        if not path.is_file():
            raise DefinitionError(f'{named_by}: there is no {name} ({path} is missing)')
        for one in self._definition(package, kind, path.stem, path).messages():
            if one.name == name:
                return one
        raise DefinitionError(f'{named_by}: there is no {name} in {path}')

    def _definition(self, package, kind, stem, path):
        if path not in self._parsed:
            self._parsed[path] = parse(package, kind, stem, path)
        return self._parsed[path]
