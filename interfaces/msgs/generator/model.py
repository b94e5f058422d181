# SPDX-License-Identifier: Apache-2.0
"""What an interface definition says, free of files, C++ and the wire."""
from dataclasses import dataclass, field
from typing import List, Optional, Union

NUMBERS = ('bool', 'byte', 'char', 'int8', 'uint8', 'int16', 'uint16', 'int32', 'uint32', 'int64', 'uint64',
           'float32', 'float64')
TEXTS = ('string', 'wstring')

SINGLE, ARRAY, BOUNDED, SEQUENCE = 'single', 'array', 'bounded', 'sequence'

# What ROS 2 puts into a structure without members.
EMPTY_MEMBER = 'structure_needs_at_least_one_member'


class DefinitionError(Exception):
    """A definition that cannot be generated; the text names file and cause."""


@dataclass(frozen=True)
class FieldType:
    kind: str                # one of NUMBERS and TEXTS, or 'message'
    message: str = ''        # 'geometry_msgs/msg/Pose' when the kind is 'message'
    shape: str = SINGLE
    bound: int = 0           # N of T[N] and T[<=N]
    text_bound: int = 0      # N of string<=N

    @property
    def is_sequence(self):
        return self.shape in (BOUNDED, SEQUENCE)


@dataclass
class Field:
    name: str
    type: FieldType
    default: object = None   # None, a number, bool, text, or a list of them


@dataclass
class Constant:
    name: str
    kind: str
    value: object


@dataclass
class Message:
    name: str                # 'pkg/msg/Name', 'pkg/srv/Name_Request'
    text: str                # its definition, comments included
    fields: List[Field] = field(default_factory=list)
    constants: List[Constant] = field(default_factory=list)

    @property
    def is_empty(self):
        return not self.fields

    def wire_fields(self):
        """The members as the wire and the hash see them: an empty message has one."""
        return self.fields or [Field(EMPTY_MEMBER, FieldType('uint8'))]


@dataclass
class Service:
    name: str
    text: str
    request: Message
    response: Message
    event: Message

    def messages(self):
        return [self.request, self.response, self.event]


@dataclass
class Action:
    name: str
    text: str
    goal: Message
    result: Message
    feedback: Message
    send_goal: Service
    get_result: Service
    feedback_message: Message

    def messages(self):
        return [self.goal, self.result, self.feedback, *self.send_goal.messages(), *self.get_result.messages(),
                self.feedback_message]


@dataclass
class Definition:
    """One .msg, .srv or .action file."""
    package: str
    kind: str                # 'msg', 'srv', 'action'
    stem: str
    content: Optional[Union[Message, Service, Action]] = None

    def messages(self):
        return [self.content] if isinstance(self.content, Message) else self.content.messages()

    def services(self):
        if isinstance(self.content, Service):
            return [self.content]
        if isinstance(self.content, Action):
            return [self.content.send_goal, self.content.get_result]
        return []

    def actions(self):
        return [self.content] if isinstance(self.content, Action) else []
