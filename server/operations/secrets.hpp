// Removes tokens and passwords from texts that came from outside.
#pragma once

#include <string>
#include <string_view>

namespace multitetra {

// Returns the text with *** for each secret: the path segment after one named "token", the value of
// a parameter whose name contains "token", "key", "secret", "password" or "auth", and words of the
// form of our tokens (mt_...); percent-encoded or not, in either case. A text without secrets is
// returned unchanged. Every text that clients send is cleaned by this before it is logged or
// repeated in an answer.
[[nodiscard]] std::string without_secrets(std::string_view text);

}  // namespace multitetra
