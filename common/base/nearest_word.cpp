#include "common/base/nearest_word.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace multitetra {
namespace {

constexpr std::size_t kLongest = 256;      // The cost is the product of the lengths.
constexpr std::size_t kMaxCost = 1 << 20;  // Of all comparisons for one word: about a millisecond.

// Returns the edit distance: letters to replace, insert or delete.
std::size_t edits(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < to.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (from[i] == to[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[to.size()];
}

std::size_t distance_of(std::string_view word, const std::string& candidate) {
  return candidate.starts_with(word) && word.size() > 3 ? 1 : edits(word, candidate);
}

}  // namespace

std::string few_of(std::string_view word, std::vector<std::string> known) {
  if (!word.empty() && word.size() <= kLongest) {
    std::stable_sort(known.begin(), known.end(), [&](const auto& a, const auto& b) {
      return distance_of(word, a) < distance_of(word, b);
    });
  }
  const std::size_t shown = known.size() <= 4 ? known.size() : 3;
  std::string text;
  for (std::size_t i = 0; i < shown; ++i) text += (i == 0 ? "\"" : ", \"") + known[i] + "\"";
  const std::size_t more = known.size() - shown;
  return text + (more > 0 ? " and " + std::to_string(more) + " more" : "");
}

std::string nearest_word(std::string_view word, std::span<const std::string> known) {
  std::string nearest;
  if (word.size() > kLongest) return nearest;
  std::size_t least = std::max<std::size_t>(2, word.size() / 4) + 1;
  std::size_t cost = 0;
  for (const std::string& candidate : known) {
    // The distance is at least the difference of the lengths.
    const bool is_longer = candidate.size() > word.size() + least && !candidate.starts_with(word);
    if (is_longer || word.size() > candidate.size() + least) continue;
    cost += word.size() * candidate.size();
    if (cost > kMaxCost) break;
    const std::size_t distance = distance_of(word, candidate);
    if (distance < least) {
      least = distance;
      nearest = candidate;
    }
  }
  return nearest;
}

std::string did_you_mean(std::string_view word, std::span<const std::string> known) {
  const std::string nearest = nearest_word(word, known);
  return nearest.empty() ? "" : " Did you mean \"" + nearest + "\"?";
}

}  // namespace multitetra
