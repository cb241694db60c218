#include "client/python/connection.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <type_traits>
#include <utility>

#include "client/python/definitions.hpp"
#include "client/python/errors.hpp"
#include "common/base/nearest_word.hpp"
#include "common/python/meshes.hpp"
#include "common/request/request_notices.hpp"
#include "common/request/shared_budget.hpp"

namespace py = pybind11;

namespace multitetra {
namespace {

// Called during waits, without the GIL. Returns whether a signal handler has raised an exception.
bool has_signal() {
  const py::gil_scoped_acquire gil;
  return PyErr_CheckSignals() != 0;
}

template <typename T>
T word(std::optional<T> value, const char* what, const std::string& text) {
  if (!value) raise(PyExc_ValueError, std::string(what) + " cannot be \"" + text + "\".");
  return *value;
}

}  // namespace

template <typename Operation>
std::invoke_result_t<const Operation&> PythonConnection::unlocked(const Operation& operation) {
  const py::gil_scoped_release release;
  const std::scoped_lock lock(mutex_);
  return operation();
}

template <typename Query, typename Answer>
typename Answer::value_type PythonConnection::run_query(const Query& query) {
  return value_of(unlocked([&]() -> Answer {
    if (auto free = free_client(); !free) return tl::unexpected(free.error());
    const auto began = std::chrono::steady_clock::now();
    Answer answer = query(*client_);
    if (!answer) note_failure(answer.error().source);
    // A connection that was lost before is noticed at once; a server that is silent is not retried.
    constexpr std::chrono::seconds kAtOnce{1};
    const bool was_lost = !answer && answer.error().source == ErrorSource::kNetwork &&
                          answer.error().error.code != ErrorCode::kCancelled;
    if (!was_lost || std::chrono::steady_clock::now() - began > kAtOnce) return answer;
    if (auto free = free_client(); !free) return tl::unexpected(free.error());
    answer = query(*client_);
    if (!answer) note_failure(answer.error().source);
    return answer;
  }));
}

PythonConnection::PythonConnection(const std::string& url, std::string token, std::string ca,
                                   bool insecure, double timeout)
    : server_(argument(parse_server_url(url))) {
  if (!(timeout > 0)) raise(PyExc_ValueError, "timeout must be greater than 0 seconds.");
  const double limited = std::min(timeout, 1e9);
  ClientOptions options{.timeout = std::chrono::milliseconds(std::llround(1000 * limited)),
                        .agent = "multitetra-python/" MULTITETRA_VERSION,
                        .token = std::move(token),
                        .trust = {.ca_file = std::move(ca), .insecure = insecure},
                        .interrupt = has_signal};
  client_.emplace(value_of(unlocked([&] { return Client::connect(server_, options); })));
}

PythonConnection::~PythonConnection() {
  const py::error_scope error;
  disconnect();
}

void PythonConnection::close() {
  disconnect();
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();
}

std::vector<DatasetInfo> PythonConnection::datasets() {
  infos_ = run_query([](Client& client) { return client.list_datasets(); });
  return infos_;
}

DatasetInfo PythonConnection::info(const std::string& name) {
  if (may_have_changed_.exchange(false)) infos_.clear();
  const auto find = [this, &name] {
    return std::find_if(infos_.begin(), infos_.end(),
                        [&name](const DatasetInfo& info) { return info.name == name; });
  };
  if (find() == infos_.end()) datasets();
  if (const auto found = find(); found != infos_.end()) return *found;
  std::vector<std::string> known;
  for (const DatasetInfo& info : infos_) known.push_back(info.name);
  throw py::key_error("The server has no dataset \"" + name + "\"." + did_you_mean(name, known));
}

EstimateReply PythonConnection::estimate(const std::string& dataset,
                                         const IsosurfaceRequest& request) {
  return run_query([&](Client& client) { return client.estimate(dataset, request); });
}

std::vector<IsosurfaceRequest> PythonConnection::share_budget(
    const std::string& dataset, std::vector<IsosurfaceRequest> requests) {
  argument(check_shared_budget(requests));
  const std::vector<std::string> datasets(requests.size(), dataset);
  run_query([&](Client& client) { return client.share_budget(datasets, requests); });
  return requests;
}

SliceReply PythonConnection::slice(const std::string& dataset, const SliceRequest& request) {
  return run_query([&](Client& client) { return client.slice(dataset, request); });
}

std::vector<ProbedPlace> PythonConnection::probe(const std::string& dataset,
                                                 const ProbeRequest& request) {
  return run_query([&](Client& client) { return client.probe(dataset, request); }).places;
}

std::uint64_t PythonConnection::open(const std::string& dataset, const IsosurfaceRequest& request,
                                     bool final_only, std::uint64_t drawable_triangles,
                                     const std::optional<ScalarRequest>& scalars) {
  OpenStream open{.dataset = dataset, .request = request, .scalars = scalars};
  if (drawable_triangles > 0) open.use = MeshUse::kDisplay;
  open.drawable_triangles = drawable_triangles;
  if (final_only) open.steps = StepPolicy::kFinalOnly;
  open_info_ = info(dataset);
  open_request_ = request;
  return value_of(unlocked([&]() -> ClientResult<std::uint64_t> {
    if (auto free = free_client(); !free) return tl::unexpected(free.error());
    const FetchOptions options{.retries = {.interrupt = has_signal}, .tiles = &tiles_};
    fetch_.emplace(*client_, open_info_, std::move(open), options);
    return streams_;
  }));
}

std::optional<FetchedSurface> PythonConnection::next(std::uint64_t stream) {
  const auto step = value_of(unlocked([this, stream]() -> ClientResult<std::optional<FetchedStep>> {
    if (stream != streams_) {
      return fail(
          ErrorSource::kServer,
          {ErrorCode::kCancelled, "Another request on this connection has ended this stream."});
    }
    if (!fetch_) return std::nullopt;
    auto next = fetch_->next();
    if (!next) note_failure(next.error().source);
    if (!next || !*next) fetch_.reset();
    return next;
  }));
  if (!step) return std::nullopt;
  const CommittedStep& made = *step->step;
  std::string empty_text;
  if (made.mesh.triangles.empty()) empty_text = empty_surface_text(open_request_, open_info_);
  const SurfaceFacts facts = {
      .length_unit = open_info_.meaning.length_unit,
      .space = std::string(name(open_info_.meaning.space)),
      .topology = made.topology,
      .digest = made.end.digest,
      .error_bound = mesh_distance_bound(made.begin, open_info_),
      .is_full_resolution = is_full_resolution(made.begin),
      .preserves_topology = preserves_topology(made.begin),
      .is_intersection_free = made.begin.request.simplify && made.begin.request.intersection_free};
  const Affine map = grid_to_world(open_info_);
  return FetchedSurface{step->step, std::move(empty_text),
                        mesh_of(made.mesh, world_vertices(made.mesh, map), map, facts)};
}

void PythonConnection::leave(std::uint64_t stream) {
  unlocked([this, stream] {
    if (stream == streams_) stop_stream();
  });
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();
}

void PythonConnection::disconnect() {
  unlocked([this] {
    fetch_.reset();
    client_.reset();
  });
}

void PythonConnection::note_failure(ErrorSource source) {
  is_lost_ |= source != ErrorSource::kServer;
  may_have_changed_ = true;
}

void PythonConnection::stop_stream() {
  if (!fetch_) return;
  is_lost_ |= !fetch_->cancel().has_value();
  fetch_.reset();
}

ClientResult<void> PythonConnection::free_client() {
  if (!client_) {
    return fail(ErrorSource::kNetwork, {ErrorCode::kUnavailable, "The connection is closed."});
  }
  ++streams_;
  stop_stream();
  if (!is_lost_) return {};
  may_have_changed_ = true;
  auto connected = client_->reconnect();
  is_lost_ = !connected.has_value();
  return connected;
}

void define_connection(py::module_& module) {
  py::class_<PythonConnection>(module, "Connection")
      .def(py::init<const std::string&, std::string, std::string, bool, double>())
      .def("close", &PythonConnection::close)
      .def("datasets", &PythonConnection::datasets)
      .def("info", &PythonConnection::info)
      .def("estimate", &PythonConnection::estimate)
      .def("share_budget", &PythonConnection::share_budget)
      .def("slice",
           [](PythonConnection& connection, const std::string& dataset,
              const std::string& coordinates, const Vec3& origin, const Vec3& right,
              const Vec3& down, std::uint32_t width, std::uint32_t height,
              const std::string& interpolation, const std::string& detail) {
             return connection.slice(
                 dataset, {.coordinates = word(coordinate_system_from(coordinates), "coordinates",
                                               coordinates),
                           .origin = origin,
                           .right = right,
                           .down = down,
                           .width = width,
                           .height = height,
                           .interpolation = word(interpolation_from(interpolation), "interpolation",
                                                 interpolation),
                           .detail = word(slice_detail_from(detail), "detail", detail)});
           })
      .def("probe",
           [](PythonConnection& connection, const std::string& dataset, std::vector<Vec3> places,
              const std::string& coordinates) {
             return connection.probe(
                 dataset, {.coordinates = word(coordinate_system_from(coordinates), "coordinates",
                                               coordinates),
                           .places = std::move(places)});
           })
      .def("open", &PythonConnection::open)
      .def("next", &PythonConnection::next)
      .def("leave", &PythonConnection::leave);
}

}  // namespace multitetra
