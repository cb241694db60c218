// Texts for users.
#pragma once

#include <string>

#include <gtest/gtest.h>

namespace multitetra::testing {

inline void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "'" << part << "' is not in: " << text;
}

}  // namespace multitetra::testing
