// The nodes of a tree on all threads, each after its children.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <stop_token>

namespace multitetra {

// Calls body(i) for all nodes i as in_parallel() does, each after those whose parent it is.
// Requires parents[i] > i for all nodes but the last one, which is the root. Of nodes that may
// begin, the one with the lowest number does: numbered depth-first, the subtrees with most work
// first, they leave threads idle for the shortest time. Throws what a body throws, and begins no
// more then.
void in_parallel_upwards(std::span<const std::size_t> parents,
                         const std::function<void(std::size_t)>& body, std::stop_token stop = {});

}  // namespace multitetra
