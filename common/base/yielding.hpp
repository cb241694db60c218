// Lets more urgent work run between the pieces of a long computation.
//
//   const YieldScope scope(&yields);   // Where a thread begins the computation.
//   in_parallel(count, body);          // Waits between its pieces whenever yields.is_due().
//
// A piece is never interrupted, and the pieces are the same; so are their results.
#pragma once

#include <utility>

namespace multitetra {

class Yields {
 public:
  virtual ~Yields() = default;
  // Whether other work waits that should run first. Cheap; called by all threads.
  [[nodiscard]] virtual bool is_due() const = 0;
  // Returns when the computation may continue, for at least a piece. Called by its own thread while
  // no piece runs; the computation may hold locks, so the wait must end whatever others do.
  virtual void wait() = 0;
  // The computation waits for the result of another one, and needs no processor until unblock().
  virtual void block() {}
  virtual void unblock() {}
};

namespace detail {

inline thread_local Yields* yields_of_this_thread = nullptr;

}  // namespace detail

// Sets what computations of this thread yield to; null: nothing.
class YieldScope {
 public:
  explicit YieldScope(Yields* yields)
      : outer_(std::exchange(detail::yields_of_this_thread, yields)) {}
  ~YieldScope() { detail::yields_of_this_thread = outer_; }
  YieldScope(const YieldScope&) = delete;
  YieldScope& operator=(const YieldScope&) = delete;

 protected:
  [[nodiscard]] Yields* outer() const { return outer_; }

 private:
  Yields* const outer_;
};

// Says, while it exists, that a computation of this thread waits for another one.
class BlockedScope {
 public:
  BlockedScope() : yields_(detail::yields_of_this_thread) {
    if (yields_ != nullptr) yields_->block();
  }
  ~BlockedScope() {
    if (yields_ != nullptr) yields_->unblock();
  }
  BlockedScope(const BlockedScope&) = delete;
  BlockedScope& operator=(const BlockedScope&) = delete;

 private:
  Yields* const yields_;
};

// A loop over pieces, which themselves do not yield: they may run on any thread.
class YieldingLoop : YieldScope {
 public:
  YieldingLoop() : YieldScope(nullptr) {}

  [[nodiscard]] bool may_yield() const { return outer() != nullptr; }
  // Whether no further piece may begin now. Safe to call from several threads at once.
  [[nodiscard]] bool is_due() const { return outer() != nullptr && outer()->is_due(); }
  void wait() const {
    if (outer() != nullptr) outer()->wait();
  }
};

}  // namespace multitetra
