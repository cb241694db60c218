// Runs a command repeatedly and prints one line: median and minimum of its seconds, and the largest
// peak of its resident memory in KiB (including pages of mapped files).
//
//   measured_run RUNS COMMAND...
//
// An additional first run warms the file cache and is not counted. The command's standard output is
// redirected to standard error. The command must succeed each time.

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

struct Run {
  double seconds = 0;
  long peak_kib = 0;
};

[[noreturn]] void fail(const char* what, const char* why) {
  std::fprintf(stderr, "measured_run: %s: %s\n", what, why);
  std::exit(1);
}

Run run(char* const* command) {
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child < 0) fail("fork", std::strerror(errno));
  if (child == 0) {
    dup2(STDERR_FILENO, STDOUT_FILENO);
    execvp(command[0], command);
    std::fprintf(stderr, "measured_run: '%s': %s\n", command[0], std::strerror(errno));
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  if (wait4(child, &status, 0, &usage) != child) fail("wait4", std::strerror(errno));
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) fail(command[0], "the command failed");
  return {.seconds = seconds.count(), .peak_kib = usage.ru_maxrss};
}

double median_of(std::vector<double> sorted) {
  const std::size_t half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

}  // namespace

int main(int count, char** arguments) {
  int runs = 0;
  if (count >= 3) {
    const std::string_view text = arguments[1];
    std::from_chars(text.data(), text.data() + text.size(), runs);
  }
  if (runs < 1 || runs > 1000) {
    std::fprintf(stderr, "Usage: measured_run RUNS COMMAND..., with 1 to 1000 runs\n");
    return 2;
  }
  run(arguments + 2);
  std::vector<double> seconds;
  long peak_kib = 0;
  for (int i = 0; i < runs; ++i) {
    const Run measured = run(arguments + 2);
    seconds.push_back(measured.seconds);
    peak_kib = std::max(peak_kib, measured.peak_kib);
  }
  std::sort(seconds.begin(), seconds.end());
  std::printf("%.6f %.6f %ld\n", median_of(seconds), seconds.front(), peak_kib);
  return 0;
}
