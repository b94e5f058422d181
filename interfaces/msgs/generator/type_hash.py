# SPDX-License-Identifier: Apache-2.0
"""RIHS01: the hash by which ROS 2 peers know that their types agree.

Source: rosidl_generator_type_description (ROS 2 jazzy), calculate_type_hash; the JSON text is compared byte by byte, so
that key order and separators are part of the algorithm.
"""
import hashlib
import json

from model import ARRAY, BOUNDED, SINGLE, Action, Service

_IDS = {'message': 1, 'int8': 2, 'uint8': 3, 'char': 3, 'int16': 4, 'uint16': 5, 'int32': 6, 'uint32': 7, 'int64': 8,
        'uint64': 9, 'float32': 10, 'float64': 11, 'bool': 15, 'byte': 16, 'string': 17, 'wstring': 18}
_BOUNDED_TEXT_IDS = {'string': 21, 'wstring': 22}
_SHAPE_OFFSETS = {SINGLE: 0, ARRAY: 48, BOUNDED: 96, 'sequence': 144}


def _type(type_):
    base = _BOUNDED_TEXT_IDS[type_.kind] if type_.text_bound else _IDS[type_.kind]
    return {'type_id': base + _SHAPE_OFFSETS[type_.shape], 'capacity': type_.bound, 'string_capacity': type_.text_bound,
            'nested_type_name': type_.message}


def _nested(name, type_name):
    return {'name': name, 'type': {'type_id': 1, 'capacity': 0, 'string_capacity': 0, 'nested_type_name': type_name}}


class Hasher:
    def __init__(self, library):
        self._library = library

    def message(self, message):
        referenced = {}
        self._collect(message, referenced)
        return self._hash(self._describe(message), referenced)

    def service(self, service):
        referenced = {}
        self._add_parts(service, referenced)
        return self._hash(self._describe_service(service), referenced)

    def action(self, action):
        referenced = {}
        self._add_parts(action, referenced)
        fields = [_nested(name, f'{action.name}_{suffix}') for name, suffix in (
            ('goal', 'Goal'), ('result', 'Result'), ('feedback', 'Feedback'), ('send_goal_service', 'SendGoal'),
            ('get_result_service', 'GetResult'), ('feedback_message', 'FeedbackMessage'))]
        return self._hash({'type_name': action.name, 'fields': fields}, referenced)

    @staticmethod
    def _describe(message):
        return {'type_name': message.name,
                'fields': [{'name': one.name, 'type': _type(one.type)} for one in message.wire_fields()]}

    @staticmethod
    def _describe_service(service):
        return {'type_name': service.name,
                'fields': [_nested(f'{part}_message', f'{service.name}_{part.capitalize()}')
                           for part in ('request', 'response', 'event')]}

    def _collect(self, message, referenced):
        for field in message.fields:
            name = field.type.message
            if name and name not in referenced:
                nested = self._library.message(name, message.name)
                referenced[name] = self._describe(nested)
                self._collect(nested, referenced)

    def _add_parts(self, definition, referenced):
        parts = definition.messages()
        if isinstance(definition, Action):
            for service in (definition.send_goal, definition.get_result):
                referenced[service.name] = self._describe_service(service)
        assert isinstance(definition, (Action, Service))
        for part in parts:
            referenced[part.name] = self._describe(part)
        for part in parts:
            self._collect(part, referenced)

    @staticmethod
    def _hash(description, referenced):
        text = json.dumps({'type_description': description,
                           'referenced_type_descriptions': [referenced[name] for name in sorted(referenced)]},
                          separators=(', ', ': '), ensure_ascii=True)
        return 'RIHS01_' + hashlib.sha256(text.encode('utf-8')).hexdigest()
