// The client's connection for Python: waits release the GIL and react to Ctrl-C. All functions
// raise Python exceptions.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "client/library/client.hpp"
#include "client/library/decoded_tile_cache.hpp"
#include "client/library/fetch.hpp"

namespace multitetra {

// A complete surface of a stream.
struct FetchedSurface {
  CommittedStepPtr committed;
  // The reason why there are no triangles; empty if there are some.
  std::string empty_text;
  pybind11::object mesh;
};

// Runs one request at a time; a new one ends a running stream. Thread-safe: calls are serialized.
class PythonConnection {
 public:
  PythonConnection(const std::string& url, std::string token, std::string ca, bool insecure,
                   double timeout);
  ~PythonConnection();

  void close();
  std::vector<DatasetInfo> datasets();
  DatasetInfo info(const std::string& name);
  EstimateReply estimate(const std::string& dataset, const IsosurfaceRequest& request);
  std::vector<IsosurfaceRequest> share_budget(const std::string& dataset,
                                              std::vector<IsosurfaceRequest> requests);
  SliceReply slice(const std::string& dataset, const SliceRequest& request);
  std::vector<ProbedPlace> probe(const std::string& dataset, const ProbeRequest& request);

  // Begins a stream and returns its number. `drawable_triangles`: 0 if the mesh is kept.
  std::uint64_t open(const std::string& dataset, const IsosurfaceRequest& request, bool final_only,
                     std::uint64_t drawable_triangles, const std::optional<ScalarRequest>& scalars);
  // Returns nullopt after the final step.
  std::optional<FetchedSurface> next(std::uint64_t stream);
  // Stops the stream if it is running.
  void leave(std::uint64_t stream);

 private:
  // Runs an operation that may wait, without the GIL.
  template <typename Operation>
  std::invoke_result_t<const Operation&> unlocked(const Operation& operation);
  // Runs a query of the client, which must be free, and returns its value.
  template <typename Query, typename Answer = std::invoke_result_t<const Query&, Client&>>
  typename Answer::value_type run_query(const Query& query);
  void disconnect();
  void note_failure(ErrorSource source);
  void stop_stream();
  // Ends a running stream, and reconnects if the connection was lost.
  ClientResult<void> free_client();

  const Endpoint server_;
  std::vector<DatasetInfo> infos_;
  // Whether the server may have other datasets than these: it refused a request, or was lost.
  std::atomic<bool> may_have_changed_ = false;
  // The dataset of the last stream.
  DatasetInfo open_info_;
  IsosurfaceRequest open_request_;
  std::mutex mutex_;              // Guards the members below.
  std::uint64_t streams_ = 0;     // The number of requests; the last one may be a stream.
  std::optional<Client> client_;  // nullopt: closed.
  DecodedTileCache tiles_;
  std::optional<Fetch> fetch_;  // The running stream.
  bool is_lost_ = false;
};

}  // namespace multitetra
