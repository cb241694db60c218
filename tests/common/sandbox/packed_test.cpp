#include "common/sandbox/packed.hpp"

#include <gtest/gtest.h>

#include <array>

namespace multitetra {
namespace {

struct Nested {
  std::string name;
  std::optional<double> number;
  friend bool operator==(const Nested&, const Nested&) = default;
};
auto fields(Nested& nested) { return std::tie(nested.name, nested.number); }

TEST(Packed, ReturnsTheSameValues) {
  const std::vector<Nested> nested = {{"a", 0.5}, {"", std::nullopt}};
  const std::filesystem::path path = "a/b";
  const std::array<int, 3> numbers = {1, -2, 3};
  const std::string bytes = packed_values(nested, path, numbers, true);
  std::vector<Nested> nested_again;
  std::filesystem::path path_again;
  std::array<int, 3> numbers_again{};
  bool flag = false;
  ASSERT_TRUE(unpack_all(bytes, nested_again, path_again, numbers_again, flag));
  EXPECT_EQ(nested_again, nested);
  EXPECT_EQ(path_again, path);
  EXPECT_EQ(numbers_again, numbers);
  EXPECT_TRUE(flag);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(unpack_all(std::string_view(bytes).substr(0, size), nested_again, path_again,
                            numbers_again, flag));
  }
  EXPECT_FALSE(unpack_all(bytes + "x", nested_again, path_again, numbers_again, flag));
}

TEST(Packed, RejectsLengthsBeyondTheBytes) {
  for (const std::uint64_t length : {std::uint64_t{9}, ~std::uint64_t{0}}) {
    const std::string bytes = packed_values(length) + "12345678";
    std::string text;
    std::vector<std::string> texts;
    std::vector<char> letters;
    EXPECT_FALSE(unpack_all(bytes, text));
    EXPECT_FALSE(unpack_all(bytes, texts));
    EXPECT_FALSE(unpack_all(bytes, letters));
  }
}

}  // namespace
}  // namespace multitetra
