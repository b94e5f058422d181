// SPDX-License-Identifier: Apache-2.0
// Laws that hold within one process only. See linked_transport_test.cpp and mirrored_laws_test.cpp for those that hold elsewhere.
#include "transport_laws.hpp"

namespace nacelle {
namespace {

template <typename T>
class WithinOneProcess : public TransportLaws<T> {};
using OneProcess = ::testing::Types<runtime::Broker, test::FakeTransport>;
TYPED_TEST_SUITE(WithinOneProcess, OneProcess);

TYPED_TEST(WithinOneProcess, an_adopted_message_is_not_copied) {
  auto writer = this->transport.create_writer(this->spec(10));
  auto reader = this->transport.create_reader(this->spec(10), Taking::Share, nullptr);
  auto message = std::make_unique<String>();
  const void* const address = message.get();
  writer->publish(*writer->adopt(message.release()));
  Block* const block = reader->take();
  ASSERT_NE(block, nullptr);
  EXPECT_EQ(block->message, address);
  drop_reference(*block);
}

}  // namespace
}  // namespace nacelle
