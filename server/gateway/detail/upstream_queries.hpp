// Forwards one client's queries (estimates, slices, probes) to servers.
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

  // Returns the reply of a server that has the dataset, retrying with another one if that is lost;
  // kUnavailable if none replies or after close(). This object must outlive the call.
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> request(
      std::shared_ptr<const UpstreamDataset> dataset, UpstreamClient client, DatasetQuery query);
  void close();

 private:
  [[nodiscard]] asio::awaitable<Result<ServerMessage>> request_once(LinkPtr link,
                                                                    DatasetQuery query);

  std::shared_ptr<UpstreamPool> upstreams_;
  std::set<LinkPtr> links_;  // Links with a pending reply.
  bool is_closed_ = false;
};

}  // namespace multitetra
