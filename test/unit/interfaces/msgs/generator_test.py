# SPDX-License-Identifier: Apache-2.0
"""What the generator says of definitions that are wrong. ctest runs it: python3 -I generator_test.py GENERATOR_DIR"""
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, sys.argv.pop(1))

from definitions import Library, used_packages  # noqa: E402
from emit_header import header  # noqa: E402
from emit_source import SourceEmitter  # noqa: E402
from model import DefinitionError  # noqa: E402


class WrongDefinitions(unittest.TestCase):
    def refusal(self, kind, text, name='Thing'):
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / 'some_msgs'
            (package / kind).mkdir(parents=True)
            (package / kind / f'{name}.{kind}').write_text(text, encoding='utf-8')
            library = Library({'some_msgs': package})
            with self.assertRaises(DefinitionError) as caught:
                found = library.package('some_msgs')
                SourceEmitter(library).source('some_msgs', found)
            return str(caught.exception)

    def test_name_the_file_and_the_line(self):
        said = self.refusal('msg', 'int8 small 200\n')
        self.assertIn('msg/Thing.msg', said)
        self.assertIn("'int8 small 200'", said)

    def test_of_a_missing_message_name_the_file_that_uses_it(self):
        said = self.refusal('msg', 'Other[] others\n')
        self.assertIn('some_msgs/msg/Thing', said)
        self.assertIn('there is no some_msgs/msg/Other', said)

    def test_of_an_unknown_package_say_where_to_name_it(self):
        self.assertIn('DEPENDS', self.refusal('msg', 'far_msgs/Thing thing\n'))

    def test_that_contain_themselves_are_refused(self):
        self.assertIn('contains itself', self.refusal('msg', 'Thing[] things\n'))

    def test_of_ros1_times_name_the_message_to_use(self):
        self.assertIn('builtin_interfaces/Duration', self.refusal('msg', 'duration left\n'))

    def test_with_too_few_or_many_parts_are_refused(self):
        self.assertIn('0 lines "---"', self.refusal('srv', 'int32 a\n'))
        self.assertIn('there must be 2', self.refusal('action', 'int32 a\n---\nint32 b\n'))

    def test_with_two_fields_of_one_name_are_refused(self):
        self.assertIn('duplicate', self.refusal('msg', 'int32 a\nint32 a\n'))


class Dependencies(unittest.TestCase):
    def test_are_seen_without_parsing(self):
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / 'some_msgs'
            for kind, text in (('msg', '# odd_msgs/Comment\nHeader header\n  geometry_msgs/Pose[] poses # far_msgs/No\n'
                                       'some_msgs/Own own\n'), ('srv', '---\n')):
                (package / kind).mkdir(parents=True)
                (package / kind / f'Thing.{kind}').write_text(text, encoding='utf-8')
            self.assertEqual(used_packages(package), {'std_msgs', 'geometry_msgs', 'service_msgs'})


class Headers(unittest.TestCase):
    def test_are_the_same_for_the_same_definition(self):
        with tempfile.TemporaryDirectory() as folder:
            package = pathlib.Path(folder) / 'some_msgs'
            (package / 'msg').mkdir(parents=True)
            (package / 'msg' / 'Thing.msg').write_text('string class "x"\nfloat32 y nan\n', encoding='utf-8')
            first, second = (header(Library({'some_msgs': package}).package('some_msgs')[0]) for _ in range(2))
        self.assertEqual(first, second)
        self.assertIn('std::string class_{std::string("x")};', first)
        self.assertIn('#include <limits>', first)


if __name__ == '__main__':
    unittest.main()
