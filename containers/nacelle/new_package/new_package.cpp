// SPDX-License-Identifier: Apache-2.0
#include "new_package/new_package.hpp"

#include <dlfcn.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>

#include "nacelle/base/files.hpp"

namespace nacelle::new_package {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 60;  // of a package; its files and its node have longer ones
constexpr std::string_view kPlace = "name";

// Keywords and macros in lower case, and what no namespace may be called.
constexpr std::string_view kReserved =
    " alignas alignof and and_eq asm assert auto bitand bitor bool break case catch char char16_t char32_t "
    "char8_t class co_await co_return co_yield compl concept const const_cast consteval constexpr constinit "
    "continue decltype default delete do double dynamic_cast else enum errno explicit export extern false float "
    "for friend goto if inline int long main mutable namespace new noexcept not not_eq nullptr operator or or_eq "
    "private protected public register reinterpret_cast requires return short signed sizeof static static_assert "
    "static_cast std struct switch template this thread_local throw true try typedef typeid typename union "
    "unsigned using virtual void volatile wchar_t while xor xor_eq ";

bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_word(char c) { return is_lower(c) || is_upper(c) || is_digit(c) || c == '_'; }

bool is_well_formed(const std::string& name) {
  const bool has_letters = std::ranges::all_of(name, [](char c) { return is_lower(c) || is_digit(c) || c == '_'; });
  return has_letters && !name.empty() && is_lower(name.front()) && name.back() != '_' &&
         name.find("__") == std::string::npos;
}

/// "my_robot" for "My-Robot" and for "MyRobot"; empty if nothing is left of the name.
std::string well_formed(const std::string& name) {
  std::string out;
  char before = '_';
  for (const char c : name) {
    if (is_upper(c) && (is_lower(before) || is_digit(before))) out += '_';
    if (is_lower(c) || is_digit(c)) out += c;
    if (is_upper(c)) out += static_cast<char>(c - 'A' + 'a');
    if (!is_word(c) || c == '_') {
      if (!out.empty() && out.back() != '_') out += '_';
    }
    before = c;
  }
  out.erase(0, out.find_first_of("abcdefghijklmnopqrstuvwxyz"));
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out.substr(0, kLongestName);
}

/// Calls `on_word(word)` for each word of a text, and `on_rest(c)` for each character between words.
template <typename OnWord, typename OnRest>
void for_each_word(std::string_view text, const OnWord& on_word, const OnRest& on_rest) {
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at;
    while (end < text.size() && is_word(text[end])) ++end;
    if (end > at) {
      on_word(text.substr(at, end - at));
      at = end;
    } else {
      on_rest(text[at++]);
    }
  }
}

std::string renamed(std::string_view text, const std::map<std::string, std::string, std::less<>>& names) {
  std::string out;
  for_each_word(
      text,
      [&](std::string_view word) {
        const auto known = names.find(word);
        out += known == names.end() ? word : std::string_view{known->second};
      },
      [&](char c) { out += c; });
  return out;
}

/// The words of C++ code, without those of its comments.
std::set<std::string, std::less<>> words_of_code(std::string_view text) {
  std::set<std::string, std::less<>> words;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string_view line = text.substr(at, end - at);
    line = line.substr(0, line.find("//"));
    for_each_word(
        line, [&](std::string_view word) { words.emplace(word); }, [](char) {});
    at = end + 1;
  }
  return words;
}

Problem cannot(const std::string& path, const std::error_code& why) {
  return {Place(path, 0), "cannot be read: " + why.message(), "install Nacelle again"};
}

}  // namespace

std::string class_name(const std::string& package) {
  std::string out;
  bool begins = true;
  for (const char c : package) {
    if (c != '_') out += begins && is_lower(c) ? static_cast<char>(c - 'a' + 'A') : c;
    begins = c == '_';
  }
  return out;
}

Result<void, Problem> check_name(const std::string& package) {
  const auto refuse = [&](std::string what, std::string way_out) {
    return err(Problem{kPlace, std::move(what), std::move(way_out), {}, package});
  };
  if (package.size() > kLongestName)
    return refuse("has " + std::to_string(package.size()) + " characters",
                  "use " + std::to_string(kLongestName) + " at most");
  if (!is_well_formed(package)) {
    const std::string near = well_formed(package);
    return refuse("invalid name '" + package + "'",
                  "use lower-case letters, digits and single underscores, first a letter" +
                      (near.empty() ? std::string{", such as wheel_counter"} : ", such as " + near));
  }
  if (kReserved.find(" " + package + " ") != std::string_view::npos)
    return refuse("'" + package + "' is reserved in C++", "use another name, such as my_" + package);
  if (constexpr std::string_view kOurs = "nacelle"; package == kOurs || package.starts_with("nacelle_"))
    return refuse("'" + package + "' is a name of Nacelle's own packages",
                  "use another name, such as my_" + (package == kOurs ? "robot" : package.substr(kOurs.size() + 1)));
  // The package's name is a namespace, which cannot share its name with a function: time, clock, index.
  if (::dlsym(RTLD_DEFAULT, package.c_str()) != nullptr)
    return refuse("'" + package + "' is a function or variable of a library",
                  "use another name, such as my_" + package);
  return {};
}

Result<std::vector<File>, Problem> read_template(const std::string& folder) {
  std::vector<File> files;
  std::error_code fault;
  for (fs::recursive_directory_iterator entry{folder, fault}, end; !fault && entry != end; entry.increment(fault)) {
    if (entry->is_directory()) continue;
    auto text = read_regular_file(entry->path().string());
    if (!text) return err(text.error());
    files.push_back({entry->path().lexically_relative(folder).string(), std::move(text).value()});
  }
  if (fault) return err(cannot(folder, fault));
  std::ranges::sort(files, {}, &File::path);
  return files;
}

Result<std::vector<File>, Problem> rename(std::vector<File> files, const std::string& example,
                                          const std::string& package) {
  const std::string old_class = class_name(example), new_class = class_name(package);
  const std::map<std::string, std::string, std::less<>> names = {{"example", package},
                                                                 {"example_" + example, package},
                                                                 {"nacelle_example_" + example, "nacelle_" + package},
                                                                 {example, package},
                                                                 {example + "_test", package + "_test"},
                                                                 {old_class, new_class}};
  for (auto& file : files) {
    if (file.path.ends_with(".cpp") && new_class != old_class && words_of_code(file.text).contains(new_class))
      return err(Problem{kPlace,
                         "the class would be called " + new_class + ", as a type that its code uses",
                         "use another name, such as my_" + package,
                         {},
                         package});
    file.text = renamed(file.text, names);
    file.path = renamed(file.path, names);
  }
  return files;
}

Result<void, Problem> write(const std::string& folder, const std::vector<File>& files) {
  if (::mkdir(folder.c_str(), 0777) != 0) {  // the umask's rights, as for the files of any editor
    const int why = errno;
    return err(why == EEXIST ? Problem{Place(folder, 0), "already exists", "use another name, or go to another folder"}
                             : Problem{Place(folder, 0), std::string{"cannot be created: "} + std::strerror(why),
                                       "go to a folder in which you may write"});
  }
  for (const auto& file : files) {
    const fs::path path = fs::path{folder} / file.path;
    std::error_code ignored;  // the file below it fails then
    fs::create_directories(path.parent_path(), ignored);
    if (const auto written = write_whole_file(path.string(), file.text); !written) {
      fs::remove_all(folder, ignored);
      return written;
    }
  }
  return {};
}

}  // namespace nacelle::new_package
