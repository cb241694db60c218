// The user's web browser, where this machine has one.
#pragma once

#include <string>

namespace multitetra {

// Opens an address with $BROWSER, else with `open` (macOS) or `xdg-open` where there is a graphical
// session. Returns false where there is none or no such program; what the browser does with the
// address is not known.
bool open_in_browser(const std::string& address);

}  // namespace multitetra
