// How all our programs run and end.
//
//   int main(int argc, char** argv) {
//     return multitetra::run_program("multitetra-this", [&] { return run(argc, argv); });
//   }
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace multitetra {

// Says on the standard error what is wrong, under the program's name. What could steer a terminal
// is shown, not obeyed.
void complain(const std::string& program, std::string_view text);

// Gives the exit code of `body`. What it throws is told, and is the code of an ExitError, kUsage of
// a std::invalid_argument, else kFailed; so is it when not all that was printed has arrived, as on
// a full disk.
[[nodiscard]] int run_program(const std::string& program, const std::function<int()>& body);

}  // namespace multitetra
