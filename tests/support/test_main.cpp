// main() of the tests: as in every program, tasks of sandboxes come first.
#include <gtest/gtest.h>

#include "common/sandbox/sandbox.hpp"

int main(int argc, char** argv) {
  multitetra::enter_sandbox_if_asked(argc, argv);
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
