#include "server/programs/view/browser.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

namespace multitetra {
namespace {

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Returns the program that opens addresses; empty without a graphical session.
std::string opener() {
  if (const std::string own = variable("BROWSER"); !own.empty()) {
    return own.substr(0, own.find(':'));  // The first of a list.
  }
#ifdef __APPLE__
  return "open";
#else
  const bool has_session = !variable("DISPLAY").empty() || !variable("WAYLAND_DISPLAY").empty();
  return has_session ? "xdg-open" : "";
#endif
}

}  // namespace

bool open_in_browser(const std::string& address) {
  std::string program = opener();
  if (program.empty()) return false;
  std::string argument = address;
  std::array<char*, 3> words = {program.data(), argument.data(), nullptr};
  // A new session, so Ctrl-C in this terminal does not end the browser.
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_t actions;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSID);
  posix_spawn_file_actions_init(&actions);
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_RDWR, 0);
  }
  pid_t id = 0;
  const int error =
      ::posix_spawnp(&id, program.c_str(), &actions, &attributes, words.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  return error == 0;
}

}  // namespace multitetra
