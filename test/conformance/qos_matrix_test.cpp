// SPDX-License-Identifier: Apache-2.0
// durability x history x depth x reliability, offered and requested, for a reader that is there before the messages and for one
// that comes after them: which messages arrive, and in which order. What is expected is computed here from the rules of DDS 1.4
// (2.2.3.4 durability, 2.2.3.14 reliability, 2.2.3.18 history), not from any transport.
#include <algorithm>
#include <tuple>

#include "transport_laws.hpp"

namespace nacelle {
namespace {

using Texts = std::vector<std::string>;

struct Side {
  const char* name;
  Durability durability;
  std::size_t depth;  // 0: keep all
  Reliability reliability;

  [[nodiscard]] QoS qos() const {
    QoS qos(depth);
    if (depth == 0) qos.keep_all();
    return qos.durability(durability).reliability(reliability);
  }
};

constexpr auto V = Durability::Volatile, T = Durability::TransientLocal;
constexpr auto B = Reliability::BestEffort, R = Reliability::Reliable;
constexpr Side kSides[] = {
    {"volatile_last1_best_effort", V, 1, B},  {"volatile_last3_best_effort", V, 3, B},
    {"volatile_all_best_effort", V, 0, B},    {"volatile_last1_reliable", V, 1, R},
    {"volatile_last3_reliable", V, 3, R},     {"volatile_all_reliable", V, 0, R},
    {"transient_last1_best_effort", T, 1, B}, {"transient_last3_best_effort", T, 3, B},
    {"transient_all_best_effort", T, 0, B},   {"transient_last1_reliable", T, 1, R},
    {"transient_last3_reliable", T, 3, R},    {"transient_all_reliable", T, 0, R},
};

Texts last(const Texts& all, std::size_t depth) {
  if (depth == 0 || depth >= all.size()) return all;
  return {all.end() - static_cast<std::ptrdiff_t>(depth), all.end()};
}

// The specification: five messages, then perhaps the joiner, then two more; nothing is taken before the end.
Texts expected(const Side& offered, const Side& requested, bool late) {
  if (offered.reliability == B && requested.reliability == R) return {};
  if (offered.durability == V && requested.durability == T) return {};
  const Texts before{"1", "2", "3", "4", "5"};
  Texts reached = before;
  if (late) reached = requested.durability == T ? last(before, offered.depth) : Texts{};
  reached.insert(reached.end(), {"6", "7"});
  return last(reached, requested.depth);
}

using Case = std::tuple<NamedTransport, Side, Side, bool>;
class QosMatrix : public ::testing::TestWithParam<Case> {};

TEST_P(QosMatrix, delivers_as_specified) {
  const auto& [named, offered, requested, late] = GetParam();
  using Laws = TransportLaws<runtime::Broker>;
  test::ManualClock clock;
  const auto transport = named.make(clock);
  auto writer = transport->create_writer(Laws::spec(offered.qos()));
  std::unique_ptr<Reader> reader;
  if (!late) reader = transport->create_reader(Laws::spec(requested.qos()), Taking::Share, nullptr);
  for (const char* text : {"1", "2", "3", "4", "5"}) Laws::send(*writer, text);
  if (late) reader = transport->create_reader(Laws::spec(requested.qos()), Taking::Share, nullptr);
  for (const char* text : {"6", "7"}) Laws::send(*writer, text);
  EXPECT_EQ(Laws::receive(*reader), expected(offered, requested, late));
  // Nothing is lost without being counted.
  const ReaderCounters counters = reader->counters();
  EXPECT_EQ(counters.received, counters.delivered + counters.overwritten);
}

std::string case_name(const ::testing::TestParamInfo<Case>& info) {
  const auto& [named, offered, requested, late] = info.param;
  return std::string(named.name) + "__" + offered.name + "__to__" + requested.name + (late ? "__late" : "__early");
}

INSTANTIATE_TEST_SUITE_P(All, QosMatrix,
                         ::testing::Combine(::testing::ValuesIn(kNamedTransports), ::testing::ValuesIn(kSides),
                                            ::testing::ValuesIn(kSides), ::testing::Bool()),
                         case_name);

}  // namespace
}  // namespace nacelle
