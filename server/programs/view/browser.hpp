// Opens the user's web browser.
#pragma once

#include <string>

namespace multitetra {

// Opens an address with $BROWSER, else with `open` (macOS) or, in a graphical session, `xdg-open`.
// Returns false if there is no session or program; does not detect whether the page loads.
bool open_in_browser(const std::string& address);

}  // namespace multitetra
