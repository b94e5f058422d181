// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <initializer_list>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace nacelle {

/// Where something is wrong: a line of a file, a parameter of a node, or what words name ("container 'robot'").
///
/// Words convert to a Place, so that `Problem{"topic /scan", ...}` can be written.
struct Place {
  std::string words;  ///< Beside a node or a parameter: what it is about, "/dev/ttyUSB0". Empty beside a file.
  std::string file;
  int line = 0, column = 0;  ///< Counted from 1; 0: not known.
  std::string node;          ///< Full name.
  std::string parameter;     ///< Of the node, or of the component that reports it, if there is no node.

  Place() = default;
  template <typename Words>  // NOLINTBEGIN(google-explicit-constructor,bugprone-forwarding-reference-overload)
  requires std::constructible_from<std::string, Words> &&
      (!std::same_as<std::remove_cvref_t<Words>, Place>)Place(Words&& text)
      : words(std::forward<Words>(text)) {}
  /// In a file; line 0: in the whole of it.
  Place(std::string path, int in_line, int in_column = 0) : file(std::move(path)), line(in_line), column(in_column) {}
  static Place of_node(std::string node);
  static Place of_parameter(std::string parameter, std::string node = {});

  [[nodiscard]] bool empty() const { return words.empty() && file.empty() && node.empty() && parameter.empty(); }
  /// "robot.launch.yaml:12", "node /lidar, parameter port_name: /dev/ttyUSB0", or the words.
  [[nodiscard]] std::string text() const;
  friend bool operator==(const Place&, const Place&) = default;
};  // NOLINTEND(google-explicit-constructor,bugprone-forwarding-reference-overload)

/// What kind of problem it is, for programs and tests: an enumerator of a domain's enum, as text "launch.unknown_key".
///
/// An enum is a domain if `code_text(E)` returns that text; it stands beside the enum.
class ProblemCode {
 public:
  ProblemCode() = default;  ///< None: the words are all there is to say.
  template <typename E>
  requires std::is_enum_v<E> && requires(E code) {
    { code_text(code) } -> std::convertible_to<const char*>;
  }
  ProblemCode(E code) : text_(code_text(code)) {}  // NOLINT(google-explicit-constructor)
  /// As another process wrote it.
  [[nodiscard]] static ProblemCode from_text(std::string text);

  [[nodiscard]] const std::string& text() const { return text_; }
  [[nodiscard]] bool empty() const { return text_.empty(); }
  friend bool operator==(const ProblemCode&, const ProblemCode&) = default;

 private:
  std::string text_;
};

/// Something outside the program is wrong: a file, a parameter, a name, a device.
///
/// The texts are sentence fragments without a full stop; empty ones are left out. A program decides by `code` and `where`, never by
/// the words.
struct Problem {
  Place where;
  std::string what;     ///< "no such device: /dev/ttyUSB7"; names the value
  std::string way_out;  ///< "see `ls /dev/serial/by-id`, or start with sim:=true"
  ProblemCode code;
  std::string value;  ///< The value that is wrong, as it was given; empty if there is none.

  /// "where: what; way_out"
  [[nodiscard]] std::string text() const;
  friend bool operator==(const Problem&, const Problem&) = default;
};

/// The candidate that a person most likely meant, or an empty text if none is near.
/// Source: Damerau-Levenshtein distance (optimal string alignment), at most a third of the longer text.
[[nodiscard]] std::string nearest_name(std::string_view wrong, const std::vector<std::string>& candidates);

/// "did you mean 'x'?", also where only the first word of 'x' is written, or "one of a, b, c"; empty without candidates.
[[nodiscard]] std::string suggestion(std::string_view wrong, const std::vector<std::string>& candidates);

/// "a, b and c"; empty for none.
[[nodiscard]] std::string join(const std::vector<std::string>& parts, std::string_view separator = ", ");

}  // namespace nacelle
