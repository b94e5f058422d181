// SPDX-License-Identifier: Apache-2.0
// Loading and unloading where it is not simple: many at once, held messages, new files, code that does not return.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <nacelle_interfaces/srv/change_state.hpp>
#include <nacelle_interfaces/srv/get_components.hpp>
#include <nacelle_interfaces/srv/get_emergency_stops.hpp>
#include <nacelle_interfaces/srv/load_component.hpp>
#include <nacelle_interfaces/srv/unload_component.hpp>
#include <stdexcept>
#include <thread>

#include "asking.hpp"
#include "container_fixture.hpp"
#include "nacelle/base/lifecycle_fault.hpp"
#include "nacelle/base/name_fault.hpp"
#include "nacelle/runtime/composition_host.hpp"
#include "nacelle/runtime/plugin_fault.hpp"
#include "nacelle/runtime/plugin_library.hpp"
#include "support/manual_clock.hpp"
#include "support/no_threads.hpp"
#include "support/places.hpp"

namespace nacelle::runtime {
namespace {

using nacelle_interfaces::srv::ChangeState;
using nacelle_interfaces::srv::GetComponents;
using nacelle_interfaces::srv::GetEmergencyStops;
using nacelle_interfaces::srv::LoadComponent;
using nacelle_interfaces::srv::UnloadComponent;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

struct LoadingTest : ContainerTest {
  Result<ComponentInfo, Problem> try_to_load(const std::string& plugin, const std::string& name = "") {
    LoadRequest request;
    request.plugin = "nacelle::test::" + plugin;
    request.name = name;
    return container.load(request);
  }
  template <typename S>
  typename S::Response asked(const std::string& service, const typename S::Request& request) {
    Call<S> call{container, "/test/_container/" + service, request};
    auto response = call.wait();
    EXPECT_TRUE(response) << service << " " << call.problem();
    return response.value_or(typename S::Response{});
  }
  // Runs it on eight threads that start together.
  template <typename F>
  static auto at_once(const F& what) {
    std::atomic<int> ready{0};
    std::array<std::future<decltype(what(0))>, 8> runs;
    for (int i = 0; i < 8; ++i) {
      runs[static_cast<std::size_t>(i)] = std::async(std::launch::async, [&, i] {
        for (++ready; ready < 8;) std::this_thread::yield();
        return what(i);
      });
    }
    std::vector<decltype(what(0))> results;
    for (auto& run : runs) results.push_back(run.get());
    return results;
  }
};

TEST_F(LoadingTest, eight_components_are_loaded_and_unloaded_at_once) {
  const auto loaded = at_once([&](int i) { return try_to_load("Talker", "talker" + std::to_string(i)); });
  for (const auto& component : loaded) ASSERT_TRUE(component) << component.error().text();
  EXPECT_THAT(container.list(), SizeIs(8));
  at_once([&](int i) {
    bring_up(loaded[static_cast<std::size_t>(i)].value().id);
    return 0;
  });

  const auto unloaded =
      at_once([&](int i) { return container.unload(loaded[static_cast<std::size_t>(i)].value().id); });
  for (const auto& outcome : unloaded) EXPECT_TRUE(outcome);
  EXPECT_THAT(container.list(), IsEmpty());
  EXPECT_THAT(container.kept_images(), IsEmpty());
  EXPECT_FALSE(is_mapped("nacelle_test_talker.so"));
}

TEST_F(LoadingTest, of_eight_loads_of_one_name_exactly_one_wins) {
  int winners = 0;
  for (const auto& loaded : at_once([&](int) { return try_to_load("Listener"); })) {
    if (loaded) {
      ++winners;
    } else {
      EXPECT_EQ(loaded.error().code, NameFault::Taken);
      EXPECT_EQ(loaded.error().value, "/listener");
      EXPECT_THAT(loaded.error().what,
                  AnyOf(HasSubstr("/listener is loaded already"), HasSubstr("/listener is being loaded just now")));
    }
  }
  EXPECT_EQ(winners, 1);
  EXPECT_THAT(container.list(), SizeIs(1));
}

// What a transition or an unload looks at before it waits is taken away by the unload that wins.
TEST_F(LoadingTest, of_eight_unloads_and_transitions_of_one_component_exactly_one_unload_wins) {
  for (int round = 0; round < 20; ++round) {
    const auto id = load("Talker").id;
    const auto outcomes = at_once([&](int i) {
      if (i % 2 != 0) return static_cast<bool>(container.unload(id));
      static_cast<void>(container.trigger(id, Transition::Configure));
      return false;
    });
    EXPECT_EQ(std::ranges::count(outcomes, true), 1);
    EXPECT_THAT(container.list(), IsEmpty());
  }
}

TEST_F(LoadingTest, a_message_in_a_readers_queue_keeps_the_image_until_it_is_read) {
  Ear late(container, "/words");
  const auto talker = load("Talker");
  bring_up(talker.id);
  EXPECT_EQ(container.unload(talker.id).value().held_by, "1 message of /words");
  ASSERT_THAT(container.kept_images(), SizeIs(1));
  EXPECT_EQ(container.kept_images().front().node, "/talker");
  EXPECT_EQ(container.kept_images().front().plugin, "nacelle::test::Talker");
  EXPECT_EQ(container.kept_images().front().held_by, "1 message of /words");
  EXPECT_TRUE(is_mapped("nacelle_test_talker.so"));
  EXPECT_THAT(container.list(), IsEmpty()) << "the instance is gone all the same";

  EXPECT_EQ(late.next(), "hello");
  EXPECT_THAT(container.kept_images(), IsEmpty());
  EXPECT_FALSE(is_mapped("nacelle_test_talker.so"));
}

TEST_F(LoadingTest, a_cache_for_late_joiners_goes_with_its_writer) {
  const auto talker = load("Talker");
  bring_up(talker.id);
  EXPECT_TRUE(container.unload(talker.id).value().image_closed);
  const auto late = container.transport().create_reader(
      {"/words", &String::message_type(), QoS(1).transient_local(), "/late"}, Taking::Share, nullptr);
  EXPECT_FALSE(late->has_waiting());
}

TEST_F(LoadingTest, thread_locals_pin_an_image_to_the_shared_thread_but_not_to_a_thread_of_its_own) {
  Ear heard(container, "/heard");
  LoadRequest request;
  request.plugin = "nacelle::test::Hoarder";
  request.thread.own = true;
  say("/words", "a");
  const auto own = container.load(request);
  EXPECT_EQ(heard.next(), "a");
  EXPECT_TRUE(container.unload(own.value().id).value().image_closed);
  EXPECT_FALSE(is_mapped("nacelle_test_hoarder.so"));

  request.thread.own = false;
  const auto shared = container.load(request);
  EXPECT_EQ(heard.next(), "a");
  EXPECT_THAT(container.unload(shared.value().id).value().held_by, HasSubstr("the process (by thread-locals"));
  ASSERT_THAT(container.kept_images(), SizeIs(1));
  EXPECT_EQ(container.kept_images().front().node, "/hoarder");
  EXPECT_TRUE(is_mapped("nacelle_test_hoarder.so"));
}

TEST_F(LoadingTest, a_missing_symbol_is_named_as_in_the_source) {
  const auto loaded = try_to_load("MissingSymbol");
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, PluginFault::NotLinked);
  EXPECT_THAT(loaded.error().value, EndsWith("/nacelle_test_missing_symbol.so"));
  EXPECT_THAT(loaded.error().text(),
              AllOf(HasSubstr("nacelle_test_missing_symbol.so cannot be loaded: "),
                    HasSubstr("undefined symbol: nacelle::test::defined_nowhere(int)"), HasSubstr("(`ldd -r ")));
  EXPECT_FALSE(is_mapped("nacelle_test_missing_symbol.so"));
}

/// A folder of plugins with one library, which the test replaces.
struct RebuiltTest : ::testing::Test {
  RebuiltTest() {
    std::string pattern = std::filesystem::temp_directory_path() / "nacelle_rebuilt_XXXXXX";
    folder = ::mkdtemp(pattern.data());
    std::filesystem::create_directory(folder / "index");
    std::ofstream(folder / "index/editions") << "nacelle::test::Edition;edition.so\n";
    install(1);
  }
  ~RebuiltTest() override { std::filesystem::remove_all(folder); }
  void install(int edition) const {
    const auto built =
        std::filesystem::path(test::component_folder()) / ("nacelle_test_edition_" + std::to_string(edition) + ".so");
    std::filesystem::copy_file(built, folder / "new.so");
    std::filesystem::rename(folder / "new.so", folder / "edition.so");
  }
  static Result<ComponentInfo, Problem> load(Container& container, const std::string& name) {
    LoadRequest request;
    request.plugin = "nacelle::test::Edition";
    request.name = name;
    return container.load(request);
  }
  static void ask(Container& container) {
    const auto writer = container.transport().create_writer({"/asked", &String::message_type(), QoS(10), "/test"});
    writer->publish(*writer->borrow());
  }
  [[nodiscard]] std::size_t mappings() const {
    std::size_t n = 0;
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) n += line.find(folder.string()) != std::string::npos ? 1 : 0;
    return n;
  }
  /// Returns the path of a mapped file whose path contains `part`; empty if there is none.
  static std::string path_of_image(const std::string& part) {
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
      if (line.find(part) != std::string::npos) return line.substr(line.find('/'));
    }
    return "";
  }
  std::filesystem::path folder;
  SystemClock clock;
};

TEST_F(RebuiltTest, a_replaced_library_runs_its_new_code_beside_the_old_one) {
  Container container{{.name = "test", .component_path = {folder}}, clock};
  Ear told(container, "/told", QoS(10));
  const auto first = load(container, "first").value();
  const std::size_t one_image = mappings();
  install(2);
  const auto second = load(container, "second").value();
  const auto third = load(container, "third").value();
  EXPECT_GT(mappings(), one_image);
  ask(container);
  EXPECT_EQ(told.next(), "first is edition 1");
  EXPECT_EQ(told.next(), "second is edition 2");
  EXPECT_EQ(told.next(), "third is edition 2");

  EXPECT_THAT(container.unload(second.id).value().held_by, HasSubstr("/third"));
  EXPECT_TRUE(container.unload(first.id).value().image_closed) << "the others have another image";
  EXPECT_TRUE(container.unload(third.id).value().image_closed);
  EXPECT_EQ(mappings(), 0U);
}

TEST_F(RebuiltTest, a_replaced_library_runs_its_new_code_while_messages_keep_the_old_image) {
  Container container{{.name = "test", .component_path = {folder}}, clock};
  Ear told(container, "/told", QoS(10)), slow(container, "/told", QoS(10));
  const auto before = load(container, "reloaded").value();
  ask(container);
  EXPECT_EQ(told.next(), "reloaded is edition 1");
  EXPECT_EQ(container.unload(before.id).value().held_by, "1 message of /told");
  install(2);
  const auto after = load(container, "reloaded").value();
  ask(container);
  EXPECT_EQ(told.next(), "reloaded is edition 2");
  EXPECT_EQ(slow.next(), "reloaded is edition 1");
  EXPECT_EQ(slow.next(), "reloaded is edition 2");
  EXPECT_TRUE(container.unload(after.id).value().image_closed);
  EXPECT_THAT(container.kept_images(), IsEmpty());
  EXPECT_EQ(mappings(), 0U);
}

TEST_F(RebuiltTest, a_library_that_was_overwritten_in_place_is_refused_while_it_is_loaded) {
  Container container{{.name = "test", .component_path = {folder}}, clock};
  const auto first = load(container, "first").value();
  std::ofstream(folder / "edition.so", std::ios::app) << "one byte more";
  const auto second = load(container, "second");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, PluginFault::OverwrittenLibrary);
  EXPECT_EQ(second.error().where, Place("component second (nacelle::test::Edition)"));
  EXPECT_EQ(second.error().value, folder / "edition.so");
  EXPECT_EQ(second.error().what, (folder / "edition.so").string() + " was overwritten while its code is loaded");
  EXPECT_TRUE(container.unload(first.id).value().image_closed);
  EXPECT_TRUE(load(container, "second"));
}

TEST_F(RebuiltTest, a_plugin_that_is_installed_later_is_found) {
  Container container{{.name = "test", .component_path = {folder}}, clock};
  EXPECT_TRUE(load(container, "first"));
  LoadRequest request;
  request.plugin = "nacelle::test::Newcomer";
  const Problem unknown = container.load(request).error();
  EXPECT_EQ(unknown.code, PluginFault::UnknownClass);
  EXPECT_EQ(unknown.where, Place("nacelle::test::Newcomer"));
  EXPECT_EQ(unknown.value, "nacelle::test::Newcomer");
  EXPECT_EQ(unknown.what, "there is no plugin nacelle::test::Newcomer in " + folder.string());

  std::ofstream(folder / "index/editions", std::ios::app) << "nacelle::test::Newcomer;edition.so\n";
  const Problem absent = container.load(request).error();
  EXPECT_EQ(absent.code, PluginFault::ClassNotInLibrary);
  EXPECT_EQ(absent.value, "nacelle::test::Newcomer");
  EXPECT_EQ(absent.text(), "nacelle::test::Newcomer: " + (folder / "edition.so").string() +
                               " holds no class nacelle::test::Newcomer; it holds nacelle::test::Edition");
}

TEST_F(RebuiltTest, an_absent_library_is_refused_with_its_path) {
  const std::string file = folder / "absent.so";

  const auto opened = PluginLibrary::open(file);

  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, PluginFault::NoLibrary);
  EXPECT_EQ(opened.error().where, Place(file, 0));
  EXPECT_EQ(opened.error().value, file);
  EXPECT_EQ(opened.error().text(), file + ": cannot be read: No such file or directory; build or install it");
}

TEST_F(RebuiltTest, a_library_without_components_is_refused_with_the_way_to_register_one) {
  const std::string file = path_of_image("/libc.so");
  ASSERT_NE(file, "");

  const auto opened = PluginLibrary::open(file);

  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, PluginFault::NotAComponentLibrary);
  EXPECT_EQ(opened.error().where, Place(file, 0));
  EXPECT_EQ(opened.error().text(),
            file +
                ": is not a component library: it has no symbol nacelle_component_table; end one "
                "source file with NACELLE_REGISTER_COMPONENT(Class)");
}

TEST_F(LoadingTest, is_refused_if_no_thread_can_be_started) {
  const auto loaded = [this] {
    const test::NoThreads none;
    return try_to_load("Talker");
  }();
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, PluginFault::NoThread);
  EXPECT_EQ(loaded.error().value, "nacelle::test::Talker");
  EXPECT_THAT(loaded.error().text(), HasSubstr("not loaded: cannot start a thread: "));
  EXPECT_THAT(loaded.error().text(), EndsWith("raise `ulimit -u`, or TasksMax= of the service"));
  EXPECT_TRUE(try_to_load("Talker"));
}

TEST_F(RebuiltTest, a_library_is_not_blamed_if_the_process_has_no_descriptor_left) {
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  const auto opened = PluginLibrary::open(folder / "edition.so");
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);

  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().code, PluginFault::TooManyFiles);
  EXPECT_EQ(opened.error().value, folder / "edition.so");
  EXPECT_THAT(opened.error().text(),
              AllOf(HasSubstr("edition.so: cannot be loaded: "), HasSubstr("Too many open files"),
                    EndsWith("; raise `ulimit -n`, or LimitNOFILE= of the service")));
}

TEST_F(LoadingTest, with_a_place_for_faults_a_component_is_made_with_defaults_and_declares_itself) {
  LoadRequest request;
  request.plugin = "nacelle::test::Sleeper";
  request.parameters = {{"entered", std::string{"x"}}, {"realese", std::int64_t{3}}, {"release", std::int64_t{-1}}};
  EXPECT_FALSE(container.load(request)) << "without one, the first fault is the end";

  request.faults = std::make_shared<ParameterFaults>();
  const auto loaded = container.load(request);

  ASSERT_TRUE(loaded) << loaded.error().text();
  ASSERT_THAT(*request.faults->lock(), SizeIs(1));
  EXPECT_EQ(request.faults->lock()->front().problem.where.parameter, "entered");
  const Declarations& declared = *loaded.value().declared;
  EXPECT_THAT(declared.unknown_parameters, testing::ElementsAre("realese"));
  EXPECT_THAT(declared.services, testing::ElementsAre("/sleeper/enable"));
  std::map<std::string, bool> given;
  for (const auto& parameter : declared.parameters) given[parameter.name] = parameter.given;
  EXPECT_TRUE(given.at("release"));
  EXPECT_FALSE(given.at("sleep_in"));
}

TEST_F(LoadingTest, reports_both_nodes_that_broadcast_one_frame) {
  const auto first = load("Sleeper", {}, "first"), second = load("Sleeper", {}, "second");

  ASSERT_THAT(container.frame_conflicts(), SizeIs(1));
  EXPECT_EQ(
      container.frame_conflicts().front().text(),
      "frame 'pillow': is broadcast twice: by /first (from 'bed') and by /second (from 'bed'); switch one of them "
      "off");
  ASSERT_THAT(container.frames(), SizeIs(2));
  EXPECT_EQ(container.frames()[1].node, "/second");
  EXPECT_NE(container.frames()[0].owns, container.frames()[1].owns) << "one of them broadcasts it";
  static_cast<void>(container.unload(first.id));
  EXPECT_THAT(container.frame_conflicts(), IsEmpty());
  static_cast<void>(container.unload(second.id));
  EXPECT_THAT(container.frames(), IsEmpty());
}

/// Components that sleep until they are woken, in a container whose time stands still until the test moves it.
struct HangingTest : ContainerFixture<test::ManualClock> {
  // A callback is late by the clock that the test moves. The test, not the supervisor, decides that one hangs.
  explicit HangingTest(NodeInterfaces which = NodeInterfaces::None)
      : ContainerFixture({.hang_after = std::chrono::hours(1'000'000), .node_interfaces = which}) {
    EXPECT_EQ(::pipe2(entered.data(), O_CLOEXEC), 0);
    EXPECT_EQ(::pipe2(release.data(), O_CLOEXEC), 0);
  }
  ~HangingTest() override {
    for (const int descriptor : {entered[0], entered[1], release[0], release[1]}) ::close(descriptor);
  }
  [[nodiscard]] std::map<std::string, ParameterValue> asleep_in(const std::string& where) const {
    return {{"sleep_in", where}, {"entered", std::int64_t{entered[1]}}, {"release", std::int64_t{release[0]}}};
  }
  void wait_until_it_sleeps() const {
    char byte = 0;
    ASSERT_EQ(::read(entered[0], &byte, 1), 1);
  }
  void wake() const { ASSERT_EQ(::write(release[1], "w", 1), 1); }
  // A return is noticed at the next check.
  void wait_until_nothing_is_kept() {
    const auto limit = std::chrono::steady_clock::now() + 20s;
    while (!container.kept_images().empty() && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
    EXPECT_THAT(container.kept_images(), IsEmpty());
  }
  // What has not returned is given up.
  template <typename T>
  T let_time_pass_for(std::future<T>& call) {
    while (call.wait_for(1ms) != std::future_status::ready) clock.advance(31s);
    return call.get();
  }
  std::string held_by() {
    const auto kept = container.kept_images();
    return kept.size() == 1 ? kept.front().held_by : std::to_string(kept.size()) + " images";
  }
  std::array<int, 2> entered{}, release{};
};

TEST_F(HangingTest, a_constructor_that_does_not_return_fails_only_its_own_load) {
  LoadRequest request;
  request.plugin = "nacelle::test::Sleeper";
  request.parameters = asleep_in("constructor");
  auto hanging = std::async(std::launch::async, [&] { return container.load(request); });
  wait_until_it_sleeps();
  Ear heard(container, "/heard");
  const auto listener = load("Listener");
  bring_up(listener.id);
  say("/words", "others go on");
  EXPECT_EQ(heard.next(), "others go on");

  const auto loaded = let_time_pass_for(hanging);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, PluginFault::TimedOut);
  EXPECT_EQ(loaded.error().value, "nacelle::test::Sleeper");
  EXPECT_EQ(loaded.error().what, "not loaded: its constructor, which has not returned within 30 s");
  EXPECT_EQ(held_by(), "its constructor, which has not returned");
  EXPECT_THAT(container.list(), SizeIs(1));

  const auto beside = load("Sleeper");
  EXPECT_EQ(beside.node, "/sleeper");
  EXPECT_THAT(container.frame_conflicts(), IsEmpty());
  EXPECT_THAT(container.unload(beside.id).value().held_by, HasSubstr("its constructor, which has not returned"));
  wake();
  wait_until_nothing_is_kept();
  EXPECT_FALSE(is_mapped("nacelle_test_sleeper.so"));
}

TEST_F(HangingTest, a_destructor_that_does_not_return_is_abandoned) {
  const auto sleeper = load("Sleeper", asleep_in("destructor"));
  auto hanging = std::async(std::launch::async, [&] { return container.unload(sleeper.id); });
  wait_until_it_sleeps();
  EXPECT_EQ(let_time_pass_for(hanging).value().held_by, "its destructor, which has not returned");
  EXPECT_EQ(held_by(), "its destructor, which has not returned");
  EXPECT_THAT(container.list(), IsEmpty());
  wake();
  wait_until_nothing_is_kept();
  EXPECT_FALSE(is_mapped("nacelle_test_sleeper.so"));
}

TEST_F(HangingTest, a_callback_that_does_not_return_keeps_the_image_and_waiting_callers_are_notified) {
  Ear heard(container, "/heard");
  const auto listener = load("Listener");
  const auto sleeper = load("Sleeper", asleep_in("service"), "talker");  // whose service the listener calls
  bring_up(listener.id);
  bring_up(sleeper.id);
  say("/ask", "?");
  wait_until_it_sleeps();
  clock.advance(1s);  // the others move to the spare thread
  say("/ask", "?");
  say("/words", "asked twice");
  EXPECT_EQ(heard.next(), "asked twice");
  auto hanging = std::async(std::launch::async, [&] { return container.unload(sleeper.id); });
  EXPECT_EQ(let_time_pass_for(hanging).value().held_by, "a callback that has not returned");
  EXPECT_EQ(heard.next(), "no answer") << "the one that is being worked on";
  EXPECT_EQ(heard.next(), "no answer") << "the one that waits";
  EXPECT_EQ(held_by(), "a callback that has not returned");
  say("/ask", "?");
  EXPECT_EQ(heard.next(), "no server");

  const auto beside = load("Sleeper", {}, "talker");
  EXPECT_THAT(container.frame_conflicts(), IsEmpty());
  EXPECT_THAT(container.unload(beside.id).value().held_by, HasSubstr("a callback that has not returned"));
  wake();
  wait_until_nothing_is_kept();
  EXPECT_FALSE(is_mapped("nacelle_test_sleeper.so"));
}

TEST_F(HangingTest, a_message_in_a_callback_that_runs_keeps_its_senders_image) {
  const auto sleeper = load("Sleeper", asleep_in("callback"));
  const auto talker = load("Talker");
  bring_up(sleeper.id);
  bring_up(talker.id);
  wait_until_it_sleeps();
  clock.advance(1s);  // the others move to the spare thread
  EXPECT_EQ(container.unload(talker.id).value().held_by, "1 message of /words");
  EXPECT_EQ(held_by(), "1 message of /words");
  EXPECT_TRUE(is_mapped("nacelle_test_talker.so"));
  wake();
  wait_until_nothing_is_kept();
  EXPECT_FALSE(is_mapped("nacelle_test_talker.so"));
}

TEST_F(HangingTest, a_slow_transition_delays_no_other_node) {
  Ear heard(container, "/heard");
  const auto listener = load("Listener");
  bring_up(listener.id);
  const auto sleeper = load("Sleeper", asleep_in("transition"));
  auto configuring =
      std::async(std::launch::async, [&] { return container.trigger(sleeper.id, Transition::Configure); });
  wait_until_it_sleeps();
  // No time has passed, so no callback was late: only the transition itself can have handed the queue over.
  say("/words", "go on");
  EXPECT_EQ(heard.next(), "go on");
  wake();
  EXPECT_EQ(configuring.get().reason, "");
}

TEST_F(HangingTest, a_transition_that_does_not_return_makes_its_component_hang_and_its_name_free) {
  const auto sleeper = load("Sleeper", asleep_in("transition"));
  auto configuring =
      std::async(std::launch::async, [&] { return container.trigger(sleeper.id, Transition::Configure); });
  wait_until_it_sleeps();
  EXPECT_THAT(let_time_pass_for(configuring).reason, HasSubstr("on_configure has not returned within 30 s"));
  EXPECT_EQ(container.find("sleeper").value().fault.code, "HUNG");
  ASSERT_EQ(container.faults().size(), 1U);
  EXPECT_EQ(container.faults()[0].callback, "transition on_configure");

  ASSERT_TRUE(container.unload(sleeper.id));
  const auto beside = load("Sleeper", {{"sleep_in", std::string("nowhere")}});
  bring_up(beside.id);

  wake();
  wait_until_nothing_is_kept();
}

TEST_F(HangingTest, a_shorter_limit_applies_to_running_waits) {
  const auto sleeper = load("Sleeper", asleep_in("transition"));
  auto configuring =
      std::async(std::launch::async, [&] { return container.trigger(sleeper.id, Transition::Configure); });
  wait_until_it_sleeps();
  clock.advance(10s);
  container.give_up_transitions_after(3s);
  clock.advance(2900ms);
  EXPECT_EQ(configuring.wait_for(200ms), std::future_status::timeout);
  clock.advance(200ms);
  EXPECT_THAT(configuring.get().reason, HasSubstr("on_configure has not returned within 13 s"));
  ASSERT_TRUE(container.unload(sleeper.id));
  wake();
  wait_until_nothing_is_kept();
}

/// Real time, and limits that are over soon: the supervisor looks at real threads.
struct ErrorProcessingTest : ContainerFixture<SystemClock> {
  ErrorProcessingTest() : ContainerFixture({.hang_after = 50ms, .transition_timeout = 200ms}) {
    EXPECT_EQ(::pipe2(entered.data(), O_CLOEXEC), 0);
    EXPECT_EQ(::pipe2(release.data(), O_CLOEXEC), 0);
  }
  ~ErrorProcessingTest() override {
    for (const int descriptor : {entered[0], entered[1], release[0], release[1]}) ::close(descriptor);
  }
  std::array<int, 2> entered{}, release{};
};

TEST_F(ErrorProcessingTest, an_on_error_that_does_not_return_is_a_fault_too_and_the_policy_may_begin) {
  std::promise<ComponentInfo> told;
  container.on_fault([&](const ComponentInfo& info) { told.set_value(info); });  // twice would throw
  const auto sleeper = load("Sleeper", {{"sleep_in", std::string{"on_error"}},
                                        {"entered", std::int64_t{entered[1]}},
                                        {"release", std::int64_t{release[0]}}});
  bring_up(sleeper.id);
  say("/words", "fault");
  auto listening = told.get_future();
  ASSERT_EQ(listening.wait_for(20s), std::future_status::ready);
  EXPECT_EQ(listening.get().fault.code, "TOLD_TO") << "the cause stays the cause";
  const auto faults = container.faults();
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_EQ(faults[1].code + ", " + faults[1].callback, "HUNG, transition on_error");
  container.on_fault({});
  // As a restart does. The parameter value persists for a later component, and is a fault again.
  EXPECT_TRUE(container.unload(sleeper.id));
  const auto beside = load("Sleeper", {{"sleep_in", std::string{"nowhere"}}});
  bring_up(beside.id);
  ASSERT_EQ(::write(release[1], "w", 1), 1);
  const auto limit = std::chrono::steady_clock::now() + 20s;
  while (!container.kept_images().empty() && std::chrono::steady_clock::now() < limit) std::this_thread::yield();
  EXPECT_THAT(container.kept_images(), IsEmpty());
}

TEST_F(HangingTest, a_transition_abandoned_before_it_began_does_not_run_later) {
  const auto sleeper = load("Sleeper", asleep_in("callback"));
  bring_up(sleeper.id);
  say("/words", "sleep");
  wait_until_it_sleeps();
  auto late = std::async(std::launch::async, [&] { return container.trigger(sleeper.id, Transition::Deactivate); });
  EXPECT_THAT(let_time_pass_for(late).reason, HasSubstr("has not returned within 30 s"));
  wake();
  EXPECT_EQ(container.trigger(sleeper.id, Transition::Activate).reason,
            "cannot activate from state active; allowed is deactivate, shutdown");
}

TEST_F(HangingTest, a_slow_transition_holds_up_no_other_service_of_the_container) {
  const auto sleeper = load("Sleeper", asleep_in("transition"));
  ChangeState::Request request;
  request.component = std::to_string(sleeper.id);
  request.transition = "configure";
  const std::string prefix = container.node() + "/_container/";
  Call<ChangeState> slow{container, prefix + "change_state", request};
  wait_until_it_sleeps();
  Call<GetComponents> other{container, prefix + "get_components", {}};
  const auto listed = other.wait();
  ASSERT_TRUE(listed);
  ASSERT_THAT(listed->components, SizeIs(1));
  EXPECT_EQ(listed->components[0].state.label, "configuring");
  EXPECT_FALSE(slow.is_answered());
  wake();
  const auto changed = slow.wait();
  ASSERT_TRUE(changed);
  EXPECT_TRUE(changed->success) << changed->problem.what;
  EXPECT_EQ(changed->state.label, "inactive");
}

struct OfferingTest : HangingTest {
  OfferingTest() : HangingTest(NodeInterfaces::All) {}
};

TEST_F(OfferingTest, a_slow_load_does_not_delay_an_offered_service) {
  const std::string prefix = container.node() + "/_container/";
  auto offered = container.offer_service(
      "get_emergency_stops", GetEmergencyStops::Request::message_type(), GetEmergencyStops::Response::message_type(),
      {[](void*, std::int64_t, const void*, void* response) {
         static_cast<GetEmergencyStops::Response*>(response)->topics = {"/emergency_stop"};
         return true;
       },
       nullptr});
  LoadComponent::Request request;
  request.component = "nacelle::test::Sleeper";
  for (const auto& [name, value] : asleep_in("constructor")) {
    auto& parameter = request.parameters.emplace_back();
    parameter.name = name;
    parameter.value.type = static_cast<std::uint8_t>(type_of(value));
    if (const auto* const text = std::get_if<std::string>(&value)) parameter.value.string_value = *text;
    if (const auto* const number = std::get_if<std::int64_t>(&value)) parameter.value.integer_value = *number;
  }
  Call<LoadComponent> slow{container, prefix + "load_component", request};
  wait_until_it_sleeps();

  const auto answer = Call<GetEmergencyStops>{container, prefix + "get_emergency_stops", {}}.wait();
  ASSERT_TRUE(answer);
  EXPECT_THAT(answer->topics, ElementsAre("/emergency_stop"));
  EXPECT_FALSE(slow.is_answered());
  wake();
  EXPECT_TRUE(slow.wait());

  offered.reset();
  const Call<GetEmergencyStops> late{container, prefix + "get_emergency_stops", {}};
  EXPECT_THAT(late.problem(), HasSubstr("no node of this process offers it"));
}

TEST_F(LoadingTest, components_load_list_and_unload_through_the_containers_own_services) {
  Ear answers(container, "/answers");
  Ear speech(container, "/robot1/speech");
  load("Caller");
  say("/calls", "load nacelle::test::Talker parrot");
  EXPECT_EQ(answers.next(), "2 /robot1/parrot");
  bring_up(2);
  EXPECT_EQ(speech.next(), "ahoy");
  say("/calls", "list");
  EXPECT_EQ(answers.next(), "1/caller 2/robot1/parrot");
  say("/calls", "load nacelle::test::Talker parrot");
  EXPECT_THAT(answers.next(), HasSubstr("/robot1/parrot is loaded already (component 2)"));
  say("/calls", "load nacelle::test::Parrot parrot");
  EXPECT_THAT(answers.next(), HasSubstr("there is no plugin nacelle::test::Parrot"));
  say("/calls", "badly nacelle::test::Talker parrot");
  EXPECT_EQ(answers.next(), "Extra component argument 'use_intra_process_comms' must be a boolean");
  say("/calls", "unload 2");
  EXPECT_EQ(answers.next(), "unloaded");
  say("/calls", "unload 2");
  EXPECT_EQ(answers.next(), "No node found with unique_id: 2");
  say("/calls", "list");
  EXPECT_EQ(answers.next(), "1/caller");
}

TEST_F(LoadingTest, a_host_answers_for_the_services_of_a_container) {
  struct Host final : CompositionHost {
    explicit Host(Container& c) : inner(c) {}
    std::string name_space() const override { return "/cage"; }
    Result<Loaded, Problem> load_planned(const std::string& name) override {
      return err(Problem{name, "is not planned", "plan it"});
    }
    Result<Loaded, Problem> load(const LoadRequest& request, bool activate) override {
      if (request.name != "parrot") return err(Problem{request.name, activate ? "may not fly" : "is not wanted", ""});
      LoadRequest elsewhere = request;
      elsewhere.name_space = "/cage";
      auto loaded = inner.load(elsewhere);
      if (!loaded) return err(loaded.error());
      return Loaded{std::move(loaded).value(), {"it screams"}};
    }
    Result<UnloadOutcome, Problem> unload(std::uint64_t) override { throw std::runtime_error("the door is shut"); }
    Container& inner;
  } host{container};
  Ear answers(container, "/answers");
  load("Caller");
  const auto answer_to = [&](const std::string& call) {
    say("/calls", call);
    return answers.next();
  };
  container.compose_through(&host);
  EXPECT_EQ(answer_to("load nacelle::test::Talker parrot"), "2 /cage/parrot");
  EXPECT_EQ(answer_to("load nacelle::test::Talker cat"), "cat: is not wanted");
  EXPECT_EQ(answer_to("unload 2"), "the door is shut");

  LoadComponent::Request request;
  request.component = "nacelle::test::Talker";
  EXPECT_EQ(asked<LoadComponent>("load_component", request).problem.what, "may not fly");
  request.component = "lidar";
  const auto planned = asked<LoadComponent>("load_component", request);
  EXPECT_FALSE(planned.success);
  EXPECT_EQ(planned.problem.where + planned.problem.what + planned.problem.way_out, "lidaris not plannedplan it");
  EXPECT_EQ(asked<GetComponents>("get_components", {}).name_space, "/cage");
  container.compose_through(nullptr);
  EXPECT_EQ(answer_to("unload 2"), "unloaded");
}

TEST_F(LoadingTest, a_plain_container_loads_activates_and_unloads_by_its_services) {
  LoadComponent::Request request;
  request.component = "nacelle::test::Talker";
  request.node_name = "parrot";
  request.remap_rules = {"speech:=/words"};
  const auto loaded = asked<LoadComponent>("load_component", request);
  EXPECT_TRUE(loaded.success) << loaded.problem.what;
  EXPECT_EQ(loaded.component.node, "/parrot");
  EXPECT_EQ(loaded.component.state.label, "active");

  const auto listed = asked<GetComponents>("get_components", {});
  EXPECT_EQ(listed.container, "/test");
  ASSERT_THAT(listed.components, SizeIs(1));
  EXPECT_EQ(listed.components[0].plugin, "nacelle::test::Talker");
  EXPECT_EQ(listed.components[0].state.id, 3);
  EXPECT_THAT(listed.components[0].fault, IsEmpty());

  ChangeState::Request change;
  change.component = "parrot";
  change.transition = "deactivate";
  const auto changed = asked<ChangeState>("change_state", change);
  EXPECT_TRUE(changed.success);
  EXPECT_EQ(changed.state.label, "inactive");
  change.transition = "configure";
  const auto refused = asked<ChangeState>("change_state", change);
  EXPECT_FALSE(refused.success);
  EXPECT_EQ(refused.problem.code, code_text(LifecycleFault::TransitionFailed));
  EXPECT_THAT(refused.problem.what, HasSubstr("cannot configure from state inactive"));
  EXPECT_EQ(refused.problem.way_out, "it is inactive now");
  change.transition = "fly";
  const auto unknown = asked<ChangeState>("change_state", change).problem;
  EXPECT_EQ(unknown.code, code_text(LifecycleFault::NoSuchTransition));
  EXPECT_EQ(unknown.what, "there is no such transition");

  request.remap_rules = {"speech"};
  EXPECT_THAT(asked<LoadComponent>("load_component", request).problem.what, HasSubstr("remap rule 'speech'"));
  request.component = "lidar";
  const auto planned = asked<LoadComponent>("load_component", request).problem;
  EXPECT_EQ(planned.code, code_text(NameFault::Unknown));
  EXPECT_EQ(planned.what, "this container has no launch file");
  UnloadComponent::Request unload;
  unload.component = "parot";
  const auto absent = asked<UnloadComponent>("unload_component", unload).problem;
  EXPECT_EQ(absent.code, code_text(NameFault::Unknown));
  EXPECT_EQ(absent.where, "component 'parot'");
  unload.component = "/parrot";
  const auto unloaded = asked<UnloadComponent>("unload_component", unload);
  EXPECT_TRUE(unloaded.success && unloaded.image_closed) << unloaded.held_by;
  EXPECT_EQ(unloaded.id, loaded.component.id);
  EXPECT_THAT(container.list(), IsEmpty());
}

}  // namespace
}  // namespace nacelle::runtime
