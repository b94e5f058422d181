// SPDX-License-Identifier: Apache-2.0
#include "cli/completion.hpp"

#include <algorithm>
#include <iterator>

namespace nacelle::cli {
namespace {

bool begins_with(const std::string& text, const std::string& beginning) { return text.rfind(beginning, 0) == 0; }

const Command* subcommand(const Command& command, const std::string& name) {
  for (const Command& below : command.subcommands()) {
    if (below.name() == name) return &below;
  }
  return nullptr;
}

const Option* option_named(const Command& command, const std::string& name) {
  for (const Option& option : command.options()) {
    const auto names = names_of(option);
    if (!option.is_positional() && std::find(names.begin(), names.end(), name) != names.end()) return &option;
  }
  return nullptr;
}

/// The positional word of that number; the last one takes all that follow if it is a list.
const Option* positional(const Command& command, std::size_t number) {
  const Option* last = nullptr;
  for (const Option& option : command.options()) {
    if (!option.is_positional()) continue;
    last = &option;
    if (number-- == 0) return last;
  }
  const bool takes_all = last != nullptr && std::holds_alternative<std::vector<std::string>*>(last->target);
  return takes_all ? last : nullptr;
}

/// Where the cursor is.
struct Place {
  const Command* command = nullptr;
  const Option* value_of = nullptr;  // the option whose value is to come
  std::vector<std::string> positional, flags;
  std::string container;
};

Place place_of(const Command& root, const std::vector<std::string>& before) {
  Place place{&root, nullptr, {}, {}, {}};
  for (const auto& word : before) {
    if (place.value_of != nullptr) {
      if (word == "=") continue;  // bash takes --option=value for three words
      if (place.value_of->names == "--container") place.container = word;
      place.value_of = nullptr;
    } else if (begins_with(word, "-") && word != "-") {
      const std::size_t equals = word.find('=');
      const Option* const option = option_named(*place.command, word.substr(0, equals));
      if (option != nullptr && option->is_flag()) place.flags.push_back(word);
      if (option == nullptr || option->is_flag()) continue;
      if (equals == std::string::npos) {
        place.value_of = option;
      } else if (option->names == "--container") {
        place.container = word.substr(equals + 1);
      }
    } else if (const Command* const below = subcommand(*place.command, word);
               below != nullptr && place.positional.empty()) {
      place.command = below;
    } else {
      place.positional.push_back(word);
    }
  }
  return place;
}

std::vector<Candidate> values_of(const Option& option, const Place& place, const AskNames& ask,
                                 const std::function<std::vector<std::string>()>& containers) {
  std::vector<Candidate> all;
  const auto add = [&](const std::vector<std::string>& words) {
    for (const auto& word : words) all.push_back({word, ""});
  };
  add(option.allowed);
  if (option.names == "--container") add(containers());
  const bool names_another = std::ranges::find(place.flags, option.completes_with.first) != place.flags.end();
  const Names names = names_another ? option.completes_with.second : option.completes;
  if (names != Names::Nothing && names != Names::File) add(ask({names, place.container, place.positional}));
  return all;
}

}  // namespace

std::vector<std::string> names_of(const Option& option) {
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin <= option.names.size();) {
    const std::size_t end = std::min(option.names.find(',', begin), option.names.size());
    if (end > begin) names.push_back(option.names.substr(begin, end - begin));
    begin = end + 1;
  }
  return names;
}

std::vector<Candidate> completions(const Command& root, std::vector<std::string> words, const AskNames& ask,
                                   const std::function<std::vector<std::string>()>& containers) {
  if (words.empty()) words.emplace_back();
  std::string current = words.back();
  words.pop_back();
  if (current == "=") current.clear();
  const Place place = place_of(root, words);
  std::string written;  // "--option=" in front of the value
  const Option* value_of = place.value_of;
  if (const std::size_t equals = current.find('=');
      value_of == nullptr && begins_with(current, "-") && equals != std::string::npos) {
    value_of = option_named(*place.command, current.substr(0, equals));
    if (value_of == nullptr) return {};
    written = current.substr(0, equals + 1);
  }

  std::vector<Candidate> all;
  if (value_of != nullptr) {
    all = values_of(*value_of, place, ask, containers);
    for (auto& candidate : all) candidate.word.insert(0, written);
  } else if (begins_with(current, "-")) {
    for (const Option& option : place.command->options()) {
      if (option.is_positional() || option.is_hidden) continue;
      for (const auto& name : names_of(option)) all.push_back({name, option.what});
    }
    all.push_back({"--help", "what it does and takes"});
    if (place.command == &root) all.push_back({"--version", "the program's version"});
  } else {
    for (const Command& below : place.command->subcommands()) {
      if (!below.is_hidden() && place.positional.empty()) all.push_back({below.name(), below.what()});
    }
    if (const Option* const option = positional(*place.command, place.positional.size()))
      std::ranges::move(values_of(*option, place, ask, containers), std::back_inserter(all));
  }
  std::erase_if(all, [&](const Candidate& candidate) { return !begins_with(candidate.word, current); });
  return all;
}

// The shells' part is small: they pass the words, and get lines of "candidate<tab>description".

const char* completion_script(const std::string& shell) {
  if (shell == "zsh") {
    return R"ZSH(#compdef nacelle
_nacelle() {
  local -a words_found descriptions
  local line
  for line in "${(@f)$("${words[1]}" __complete -- "${(@)words[2,CURRENT]}" 2>/dev/null)}"; do
    [[ -n $line ]] || continue
    words_found+=("${line%%$'\t'*}")
    descriptions+=("${line/$'\t'/  -- }")
  done
  if (( $#words_found )); then
    compadd -l -d descriptions -a words_found
  else
    _files
  fi
}
if [[ ${funcstack[1]} == _nacelle ]]; then _nacelle "$@"; else compdef _nacelle nacelle; fi
)ZSH";
  }
  if (shell == "fish") {
    return R"FISH(function __nacelle_complete
  set -l words (commandline -opc) (commandline -ct)
  set -l found ($words[1] __complete -- $words[2..-1] 2>/dev/null)
  if test (count $found) -gt 0
    printf '%s\n' $found
  else
    __fish_complete_path (commandline -ct)
  end
end
complete -c nacelle -f -a '(__nacelle_complete)'
)FISH";
  }
  // bash breaks words at ':' and '=' too, and replaces only the text after the last of them.
  return R"BASH(_nacelle() {
  local line=${COMP_LINE:0:COMP_POINT} words current before
  read -ra words <<<"$line"
  [[ $line == *[[:space:]] ]] && words+=("")
  current=${words[-1]}
  mapfile -t COMPREPLY < <("${words[0]/#\~/$HOME}" __complete -- "${words[@]:1}" 2>/dev/null | cut -f1)
  before=${current%"${current##*[:=]}"}
  [[ -z $before ]] || COMPREPLY=("${COMPREPLY[@]#"$before"}")
}
complete -o default -F _nacelle nacelle
)BASH";
}

}  // namespace nacelle::cli
