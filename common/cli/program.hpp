// Runs a program's body and turns exceptions into exit codes.
//
//   int main(int argc, char** argv) {
//     return multitetra::run_program("multitetra-this", [&] { return run(argc, argv); });
//   }
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace multitetra {

// Prints an error to standard error, with the program's name. Escapes control characters.
void print_error(const std::string& program, std::string_view text);

using ErrorPrinter = std::function<void(const std::string& program, std::string_view text)>;

// Returns the exit code of `body`. Prints exceptions and maps them to exit codes: that of an
// ExitError, kUsage for std::invalid_argument, otherwise kFailed. Standard output that cannot be
// written, for example to a full disk, also gives kFailed.
[[nodiscard]] int run_program(const std::string& program, const std::function<int()>& body,
                              const ErrorPrinter& print = print_error);

}  // namespace multitetra
