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

// Prints an error to the standard error, with the program's name. Control characters are escaped.
void print_error(const std::string& program, std::string_view text);

// Returns the exit code of `body`. An exception is printed and gives the code of an ExitError,
// kUsage for a std::invalid_argument, else kFailed; so does output that could not be written, as on
// a full disk.
[[nodiscard]] int run_program(const std::string& program, const std::function<int()>& body);

}  // namespace multitetra
