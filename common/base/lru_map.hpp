// A map of bounded weight that evicts the least recently used entry.
//
//   LruMap<std::string, Picture> pictures(/*capacity=*/1 << 30);
//   pictures.add("a", picture, picture.bytes());
//   if (const Picture* picture = pictures.find("a")) show(*picture);
//
// Not thread-safe. Operations cost O(log size).
#pragma once

#include <cstddef>
#include <iterator>
#include <list>
#include <map>
#include <utility>

namespace multitetra {

template <typename Key, typename Value>
class LruMap {
 public:
  // The total weight of the entries never exceeds `capacity`.
  explicit LruMap(std::size_t capacity) : capacity_(capacity) {}

  // Returns the value, valid until the next add(), or null. Counts as a use.
  [[nodiscard]] const Value* find(const Key& key) {
    const auto found = entries_.find(key);
    if (found == entries_.end()) return nullptr;
    by_use_.splice(by_use_.begin(), by_use_, found->second);
    return &found->second->value;
  }

  // Does not count as a use.
  [[nodiscard]] bool contains(const Key& key) const { return entries_.contains(key); }

  // Returns the first entry with a key of at least `key` for which wanted() is true, or null. Stops
  // at the first key for which in_range() is false. Counts as a use.
  template <typename InRange, typename Wanted>
  [[nodiscard]] const Value* find_from(const Key& key, const InRange& in_range,
                                       const Wanted& wanted) {
    for (auto at = entries_.lower_bound(key); at != entries_.end() && in_range(at->first); ++at) {
      if (wanted(at->first)) return find(at->first);
    }
    return nullptr;
  }

  struct Entry {
    Key key;
    Value value;
    std::size_t weight;
  };
  using Evicted = std::list<Entry>;

  // Adds or replaces an entry. Ignores values heavier than the capacity. Returns the evicted
  // entries, which callers can then free without holding a lock.
  Evicted add(const Key& key, Value value, std::size_t weight) {
    Evicted evicted;
    remove(key);
    if (weight > capacity_) return evicted;
    while (weight_ > capacity_ - weight) evicted.splice(evicted.begin(), extract(oldest()));
    by_use_.push_front({key, std::move(value), weight});
    entries_.emplace(key, by_use_.begin());
    weight_ += weight;
    return evicted;
  }

  void remove(const Key& key) {
    if (const auto found = entries_.find(key); found != entries_.end()) extract(found->second);
  }

  // Removes the entries with keys in [begin, end).
  void remove_between(const Key& begin, const Key& end) {
    const auto last = entries_.lower_bound(end);
    for (auto at = entries_.lower_bound(begin); at != last;) extract((at++)->second);
  }

  // Returns false if the map is empty.
  bool evict_oldest() {
    if (by_use_.empty()) return false;
    extract(oldest());
    return true;
  }

  // The most recently used entry is first.
  [[nodiscard]] const std::list<Entry>& entries() const { return by_use_; }

  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  [[nodiscard]] std::size_t weight() const { return weight_; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }

 private:
  using Place = typename std::list<Entry>::iterator;

  [[nodiscard]] Place oldest() { return std::prev(by_use_.end()); }

  Evicted extract(Place place) {
    weight_ -= place->weight;
    entries_.erase(place->key);
    Evicted entry;
    entry.splice(entry.begin(), by_use_, place);
    return entry;
  }

  std::size_t capacity_;
  std::size_t weight_ = 0;
  // The most recently used is first.
  std::list<Entry> by_use_;
  std::map<Key, Place> entries_;
};

}  // namespace multitetra
