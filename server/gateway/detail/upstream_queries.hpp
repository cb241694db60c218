// Queries (estimates, slices, probes) that servers answer for one client of a gateway.
#pragma once

#include <cstddef>
#include <memory>
#include <set>
#include <string>

#include "server/gateway/detail/upstream_pool.hpp"
#include "server/service/dataset_queries.hpp"

namespace multitetra {

class UpstreamQueries {
 public:
  explicit UpstreamQueries(std::shared_ptr<UpstreamPool> upstreams)
      : upstreams_(std::move(upstreams)) {}

  // The reply of a server that has the dataset, or of another one when it is lost; kUnavailable
  // when none does, and for all that are waited for after close(). This must outlive the call.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> ask(
      std::shared_ptr<const UpstreamDataset> dataset, UpstreamClient client, DatasetQuery query);
  void close();

 private:
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> ask_one(LinkPtr link, DatasetQuery query);

  std::shared_ptr<UpstreamPool> upstreams_;
  std::set<LinkPtr> links_;  // An answer is waited for on each.
  bool is_closed_ = false;
};

}  // namespace multitetra
