// Processes the nodes of a tree on all threads, children before parents.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <stop_token>

namespace multitetra {

// Calls body(i) for all nodes i as in_parallel() does, each after its children. Requires that
// parents[i] > i for all nodes but the last, which is the root. Of the nodes that are ready, the
// one with the lowest number starts first: a depth-first numbering with the largest subtrees first
// minimizes idle time. Rethrows an exception of a body and starts no further nodes.
void in_parallel_upwards(std::span<const std::size_t> parents,
                         const std::function<void(std::size_t)>& body, std::stop_token stop = {});

}  // namespace multitetra
