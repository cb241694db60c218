// What a program's options say of themselves, for a shell and for `man`. Both pages are made from
// the same tree of options as --help, so none of them can be out of date.
#pragma once

#include <string>

#include "common/cli/command.hpp"

namespace multitetra {

// A script for bash that completes subcommands, options, the words that an option takes one of, and
// files. For use as:  source <(multitetra-client --completion)
[[nodiscard]] std::string bash_completion(const Command& program);

// The manual page of section 1 with all subcommands, in roff. For use as:
// multitetra-client --man | man -l -
[[nodiscard]] std::string manual_page(const Command& program);

}  // namespace multitetra
