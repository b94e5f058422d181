// SPDX-License-Identifier: Apache-2.0
#include "recording_commands/bag_check.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "cli/output.hpp"
#include "cli/program.hpp"
#include "nacelle/base/problem_json.hpp"
#include "nacelle/msgs/any_message.hpp"
#include "nacelle/msgs/type_library.hpp"
#include "record/model/recording_check.hpp"
#include "record/port/recording_file.hpp"
#include "recording_commands/recording_files.hpp"

namespace nacelle::cli {
namespace {

using nlohmann::json;
using record::PayloadVerdict;

/// Decodes messages of the types that this program has libraries of.
class Payloads {
 public:
  Payloads() : library_(message_library_directories()) {}

  PayloadVerdict look_at(const std::string& type, const std::string& encoding, ByteView bytes) {
    if (encoding != "cdr") return PayloadVerdict::UnknownType;
    auto known = messages_.find(type);
    if (known == messages_.end()) {
      auto found = library_.message(type);
      known = messages_.try_emplace(type).first;
      if (found) known->second.emplace(**found);
    }
    auto& message = known->second;
    if (!message) return PayloadVerdict::UnknownType;
    return message->type().decode(bytes, message->get()) ? PayloadVerdict::Good : PayloadVerdict::Bad;
  }

 private:
  msgs::TypeLibrary library_;
  std::map<std::string, std::optional<msgs::AnyMessage>> messages_;  // of unknown types: empty
};

std::string summary_of(const record::RecordingCheck::Report& report) {
  const auto plural = [](std::uint64_t count) { return count == 1 ? "" : "s"; };
  std::string text = fmt::format("{} message{} in {} chunk{}, {} of them indexed, {} checksum{} compared",
                                 report.messages, plural(report.messages), report.chunks, plural(report.chunks),
                                 report.indexed, report.checksums, plural(report.checksums));
  for (const auto& [type, count] : report.unread)
    text +=
        fmt::format("; {} of {} were not decoded: the type is not installed", count, type.empty() ? "no type" : type);
  return text;
}

json row_of(const std::string& file, const record::RecordingCheck::Report& report) {
  json problems = json::array();
  for (const auto& problem : report.problems) problems.push_back(problem_of(file, problem));
  return {{"file", file},
          {"complete", report.complete},
          {"messages", report.messages},
          {"chunks", report.chunks},
          {"indexed", report.indexed},
          {"checksums", report.checksums},
          {"not_decoded", report.unread},
          {"problem_count", report.problem_count},
          {"problems", std::move(problems)}};
}

}  // namespace

int check_bag(const BagCheckWish& wish) {
  const auto files = recording_files(wish.path);
  if (!files) return complain(files.error());
  Payloads payloads;
  json rows = json::array();
  bool good = true;
  for (const auto& file : *files) {
    if (is_sqlite(file))
      return complain(Problem{Place{file, 0},
                              "is checked by SQLite only: it has no checksums and no indexes of its own",
                              "make an MCAP file of it: `nacelle bag convert`", record::McapFault::NoMagic, ""});
    auto source = record::FileSource::open(file);
    if (!source) return complain(source.error());
    record::RecordingCheck check{**source, [&](const std::string& type, const std::string& encoding, ByteView bytes) {
                                   return payloads.look_at(type, encoding, bytes);
                                 }};
    const auto report = check.run();
    good = good && report.problem_count == 0;
    if (wish.as_json) {
      rows.push_back(row_of(file, report));
      continue;
    }
    for (const auto& problem : report.problems) print_text("%s\n", problem_of(file, problem).text().c_str());
    if (report.problem_count > report.problems.size())
      print_text("%s: and %zu more\n", file.c_str(),
                 static_cast<std::size_t>(report.problem_count - report.problems.size()));
    print_text("%s: %s: %s\n", file.c_str(), report.problem_count == 0 ? "ok" : "wrong", summary_of(report).c_str());
  }
  if (wish.as_json) std::printf("%s\n", rows.dump(2, ' ', false, json::error_handler_t::replace).c_str());
  return good ? kDone : kFailed;
}

}  // namespace nacelle::cli
