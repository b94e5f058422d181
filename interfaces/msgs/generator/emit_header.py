# SPDX-License-Identifier: Apache-2.0
"""The header of one definition file."""
import cpp_names as cpp
from model import Action, Message, Service

_VISIBLE = '[[gnu::visibility("default")]]'


def _needs_limits(messages):
    def non_finite(value):
        return isinstance(value, float) and (value != value or value in (float('inf'), float('-inf')))
    values = []
    for message in messages:
        values += [constant.value for constant in message.constants]
        for field in message.fields:
            values += field.default if isinstance(field.default, list) else [field.default]
    return any(non_finite(value) for value in values)


def _includes(definition):
    paths = set()
    for message in definition.messages():
        for field in message.fields:
            if field.type.message:
                package, kind, stem = field.type.message.split('/')
                if kind == 'msg':  # Derived parts are in this very file.
                    paths.add(cpp.header_path(package, kind, stem))
    if isinstance(definition.content, Action):
        paths |= {'action_msgs/msg/goal_status_array.hpp', 'action_msgs/srv/cancel_goal.hpp'}
    return sorted(paths)


def _constant(constant):
    # A C string converts to std::string and costs no start-up code.
    type_ = {'string': 'const char*', 'wstring': 'const char16_t*'}.get(constant.kind)
    name = cpp.member_name(constant.name)
    if type_ is None:
        type_ = cpp.field_type(_single(constant.kind))
    return f'  static constexpr {type_} {name} = {cpp.literal(constant.kind, constant.value)};'


def _single(kind):
    from model import FieldType
    return FieldType(kind)


def _struct(message):
    name = message.name.split('/')[-1]
    lines = [f'/// {message.name}', f'struct {name} {{',
             f'  using SharedPtr = std::shared_ptr<{name}>;',
             f'  using ConstSharedPtr = std::shared_ptr<const {name}>;',
             f'  using UniquePtr = std::unique_ptr<{name}>;', '']
    if message.constants:
        lines += [_constant(constant) for constant in message.constants] + ['']
    for field in message.wire_fields():
        lines.append(f'  {cpp.field_type(field.type)} {cpp.member_name(field.name)}{cpp.initializer(field)};')
    lines += ['', f'  {_VISIBLE} static const nacelle::msgs::MessageType& message_type();',
              f'  friend bool operator==(const {name}&, const {name}&) = default;', '};', '']
    return lines


def _service(service):
    name = service.name.split('/')[-1]
    return [f'/// {service.name}', f'struct {name} {{', f'  using Request = {name}_Request;',
            f'  using Response = {name}_Response;', f'  using Event = {name}_Event;',
            f'  {_VISIBLE} static const nacelle::msgs::ServiceType& service_type();', '};', '']


def _action(action):
    name = action.name.split('/')[-1]
    return [f'/// {action.name}', f'struct {name} {{', *(f'  using {part} = {name}_{part};' for part in (
        'Goal', 'Result', 'Feedback', 'SendGoal', 'GetResult', 'FeedbackMessage')),
            '  /// What the parts of every action are, in the names that rclcpp_action uses.', '  struct Impl {',
            f'    using SendGoalService = {name}_SendGoal;', f'    using GetResultService = {name}_GetResult;',
            f'    using FeedbackMessage = {name}_FeedbackMessage;',
            '    using CancelGoalService = ::action_msgs::srv::CancelGoal;',
            '    using GoalStatusMessage = ::action_msgs::msg::GoalStatusArray;', '  };',
            f'  {_VISIBLE} static const nacelle::msgs::ActionType& action_type();', '};', '']


def header(definition):
    lines = ['// SPDX-License-Identifier: Apache-2.0',
             f'// Generated from {definition.package}/{definition.kind}/{definition.stem}.{definition.kind}.',
             '#pragma once', '', '#include "nacelle/msgs/message.hpp"',
             *(f'#include "{path}"' for path in _includes(definition))]
    if _needs_limits(definition.messages()):
        lines.append('#include <limits>')
    lines += ['', f'namespace {definition.package}::{definition.kind} {{', '']
    content = definition.content
    if isinstance(content, Message):
        lines += _struct(content)
    elif isinstance(content, Service):
        for message in content.messages():
            lines += _struct(message)
        lines += _service(content)
    elif isinstance(content, Action):
        for message in content.messages():
            lines += _struct(message)
        lines += _service(content.send_goal) + _service(content.get_result) + _action(content)
    lines += [f'}}  // namespace {definition.package}::{definition.kind}', '']
    return '\n'.join(lines)
