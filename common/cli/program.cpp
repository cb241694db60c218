#include "common/cli/program.hpp"

#include <unistd.h>

#include <cerrno>
#include <exception>
#include <iostream>
#include <new>
#include <stdexcept>
#include <system_error>

#include "common/base/exit_codes.hpp"
#include "common/cli/terminal.hpp"

namespace multitetra {
namespace {

void flush_output() {
  errno = 0;
  if (std::cout.flush()) return;
  throw std::system_error(errno != 0 ? errno : EIO, std::generic_category(),
                          "Cannot write to the standard output");
}

}  // namespace

void print_error(const std::string& program, std::string_view text) {
  std::cerr << styled(Style::kRed, program + ":", STDERR_FILENO) << " " << printable(text) << "\n";
}

int run_program(const std::string& program, const std::function<int()>& body,
                const ErrorPrinter& print) {
  try {
    const int code = body();
    flush_output();
    return code;
  } catch (const ExitError& error) {
    print(program, error.what());
    return error.code();
  } catch (const std::invalid_argument& error) {  // Options only the work can check.
    print(program, error.what());
    return kUsage;
  } catch (const std::bad_alloc&) {
    print(program,
          "Not enough memory on this machine or for this process; allow a larger error or "
          "use a larger machine.");
  } catch (const std::exception& error) {
    print(program, error.what());
  }
  return kFailed;
}

}  // namespace multitetra
