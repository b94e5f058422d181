# SPDX-License-Identifier: Apache-2.0
"""A definition with everything it depends on in one text, as recorders store it (MCAP's "ros2msg" encoding).

Source: rosbag2 local_message_definition_source: the text itself, then each dependency once, depth first, behind a line
of 80 '=' and a line "MSG: package/Type".
"""
_DELIMITER = '=' * 80


class DefinitionTexts:
    def __init__(self, library):
        self._library = library

    def of(self, text, messages):
        """The whole text of a definition whose own text is `text` and whose fields are those of `messages`."""
        pieces, seen = [text], set()
        own = {message.name for message in messages}
        for message in messages:
            self._append(message, pieces, seen | own, seen)
        return ''.join(pieces)

    def _append(self, message, pieces, known, seen):
        for name in sorted({field.type.message for field in message.fields if field.type.message}):
            if name in known or name in seen:
                continue
            seen.add(name)
            nested = self._library.message(name, message.name)
            package, _, stem = name.split('/')
            pieces.append(f'\n{_DELIMITER}\nMSG: {package}/{stem}\n{nested.text}')
            self._append(nested, pieces, known, seen)
