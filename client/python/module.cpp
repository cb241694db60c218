// The Python module multitetra._client: the C++ client with the types of Python and NumPy. Waits
// release the GIL and react to Ctrl-C; what is named and documented for users is in the package's
// Python files.
#include <cmath>
#include <filesystem>
#include <limits>
#include <mutex>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "client/library/fetch.hpp"
#include "common/base/nearest_word.hpp"
#include "common/base/number_text.hpp"
#include "common/request/request_notices.hpp"
#include "common/request/shared_budget.hpp"
#include "common/request/surface_query.hpp"
#include "common/wire/mesh_files.hpp"

namespace py = pybind11;
using namespace pybind11::literals;

namespace multitetra {
namespace {

// ---- errors

// Classes of exceptions, which live as long as the interpreter.
PyObject* server_error = nullptr;
PyObject* check_error = nullptr;

[[noreturn]] void raise(PyObject* type, const std::string& text) {
  PyErr_SetString(type, text.c_str());
  throw py::error_already_set();
}

[[noreturn]] void raise(const ClientError& failure) {
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();  // KeyboardInterrupt.
  const auto& [code, text, retry_after] = failure.error;
  if (failure.source == ErrorSource::kCheck) raise(check_error, text);
  if (failure.source == ErrorSource::kNetwork) raise(PyExc_ConnectionError, text);
  const std::string code_name(name(code));
  py::object error = py::handle(server_error)(text + " (" + code_name + ")");
  error.attr("code") = code_name;
  error.attr("retry_after") = retry_after;
  PyErr_SetObject(server_error, error.ptr());
  throw py::error_already_set();
}

template <typename T>
T value_of(ClientResult<T> result) {
  if (!result) raise(result.error());
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

// What a caller has written: a ValueError where it is wrong.
template <typename T>
T argument(Result<T> result) {
  if (!result) raise(PyExc_ValueError, result.error().text);
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

template <typename T>
T word(std::optional<T> value, const char* what, const std::string& text) {
  if (!value) raise(PyExc_ValueError, std::string(what) + " cannot be \"" + text + "\".");
  return *value;
}

// Called without the GIL, from a wait: whether Python has something that ends it.
bool has_signal() {
  const py::gil_scoped_acquire gil;
  return PyErr_CheckSignals() != 0;
}

// ---- arrays

template <typename T, typename Rows>
py::object rows_of(const Rows& rows) {
  const py::array_t<T> array({static_cast<py::ssize_t>(rows.size()), py::ssize_t{3}});
  T* out = const_cast<T*>(array.data());
  for (const auto& row : rows) out = std::copy(row.begin(), row.end(), out);
  return array;
}

// In double precision, so that no vertex moves. Faces are turned over where the map mirrors.
py::object mesh_of(const LatticeMesh& mesh, const Affine& grid_to_world,
                   std::optional<double> error_bound, bool is_full_resolution) {
  std::vector<Vec3> vertices;
  vertices.reserve(mesh.vertices.size());
  const double step = std::ldexp(1.0, -mesh.resolution);
  for (const LatticePoint& v : mesh.vertices) {
    vertices.push_back(grid_to_world({v.x * step, v.y * step, v.z * step}));
  }
  std::vector<TriangleIndices> faces = mesh.triangles;
  if (grid_to_world.determinant() < 0) {
    for (TriangleIndices& face : faces) std::swap(face[1], face[2]);
  }
  py::object normals = py::none();
  if (!mesh.normals.empty()) normals = rows_of<float>(mesh.normals);
  py::object scalars = py::none();
  if (!mesh.scalars.empty()) {
    scalars =
        py::array_t<float>(static_cast<py::ssize_t>(mesh.scalars.size()), mesh.scalars.data());
  }
  return py::module_::import("multitetra.mesh")
      .attr("Mesh")(rows_of<double>(vertices), rows_of<std::uint32_t>(faces), normals, scalars,
                    error_bound, is_full_resolution);
}

template <typename T>
using Rows = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <typename T>
std::vector<std::array<T, 3>> rows_from(const Rows<T>& rows, const char* what) {
  if (rows.ndim() != 2 || rows.shape(1) != 3) {
    raise(PyExc_ValueError, std::string(what) + " are an array of rows of three numbers.");
  }
  std::vector<std::array<T, 3>> out(static_cast<std::size_t>(rows.shape(0)));
  const T* from = rows.data();
  for (auto& row : out) {
    std::copy_n(from, 3, row.begin());
    from += 3;
  }
  return out;
}

// The format is that of the path's suffix.
void save_mesh(const std::string& path, const Rows<float>& vertices,
               const Rows<std::uint32_t>& faces, const std::optional<Rows<float>>& normals,
               const std::optional<py::array_t<float, py::array::forcecast>>& scalars) {
  const auto format = mesh_format_from(std::filesystem::path(path).extension().string());
  if (!format) {
    raise(PyExc_ValueError, "\"" + path +
                                "\" is no name of a mesh; meshes are *.ply, *.stl, *.obj, "
                                "*.glb, *.drc and *.vtp.");
  }
  PositionedMesh mesh{.positions = rows_from(vertices, "Vertices"),
                      .triangles = rows_from(faces, "Faces")};
  for (const TriangleIndices& face : mesh.triangles) {
    for (const std::uint32_t corner : face) {
      if (corner >= mesh.positions.size()) {
        raise(PyExc_ValueError, "Faces name vertex " + std::to_string(corner) + ", and there are " +
                                    std::to_string(mesh.positions.size()) + ".");
      }
    }
  }
  if (normals) mesh.normals = rows_from(*normals, "Normals");
  if (scalars) mesh.scalars.assign(scalars->data(), scalars->data() + scalars->size());
  const std::size_t count = mesh.positions.size();
  if ((normals && mesh.normals.size() != count) || (scalars && mesh.scalars.size() != count)) {
    raise(PyExc_ValueError, "Normals and scalars are one for each vertex.");
  }
  try {
    write_file(path, mesh_file(mesh, *format));
  } catch (const std::system_error& problem) {
    raise(PyExc_OSError, problem.what());
  }
}

// ---- requests

// A value of Python as the table of fields reads it: numbers, words, True for "on", and sequences
// of numbers.
std::string text_of(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "on" : "off";
  if (py::isinstance<py::str>(value) || py::isinstance<py::int_>(value)) return py::str(value);
  if (py::hasattr(value, "__float__")) return shortest_text(value.cast<double>());
  std::string text;
  for (const py::handle each : value) text += (text.empty() ? "" : ",") + text_of(each);
  return text;
}

// The plural where a field may be repeated, as its value is a list.
std::string keyword_of(const RequestField& field) {
  return std::string(field.name) + (field.is_repeatable ? "s" : "");
}

// What is about a file is for Python's users to do, and the isovalue is an argument of its own.
bool is_keyword(const RequestField& field) {
  const bool is_of_file = field.group == FieldGroup::kFile || field.name == "colors" ||
                          field.name == "color_scale" || field.name == "no_value_color";
  return !is_of_file && field.name != "isovalue";
}

void set(const RequestField& field, const py::handle& value, SurfaceQuery& query) {
  const std::string text = text_of(value);
  if (const FieldError wrong = field.set(field, text, query)) {
    raise(PyExc_ValueError, keyword_of(field) + " " + text + ": " + *wrong + ".");
  }
}

// The request, and what colors its surface.
std::pair<IsosurfaceRequest, std::optional<ScalarRequest>> surface_request(
    double isovalue, const std::shared_ptr<ThresholdGrid>& threshold_grid,
    const py::dict& keywords) {
  SurfaceQuery query{.isovalues = {isovalue}};
  query.request.thresholds.grid = threshold_grid;
  for (const auto& [key, value] : keywords) {
    const auto name = key.cast<std::string>();
    const auto fields = request_fields();
    const auto field = std::find_if(fields.begin(), fields.end(), [&](const RequestField& f) {
      return is_keyword(f) && keyword_of(f) == name;
    });
    if (field == fields.end()) raise(PyExc_TypeError, "A request has no \"" + name + "\".");
    if (value.is_none()) continue;
    if (!field->is_repeatable) set(*field, value, query);
    if (field->is_repeatable) {
      for (const py::handle each : value) set(*field, each, query);
    }
  }
  return {argument(requests_for(query, DatasetInfo{})).front(), argument(scalars_for(query))};
}

// A ValueError unless values of a dataset may color surfaces of another.
void check_one_world(const DatasetInfo& surface, const DatasetInfo& values) {
  argument(check_colors({}, surface, values));
}

// Lists for every keyword its name, the form of its value, its default as text, and its meaning.
py::list request_keywords() {
  py::list keywords;
  for (const RequestField& field : request_fields()) {
    if (!is_keyword(field)) continue;
    keywords.append(
        py::make_tuple(keyword_of(field), field.value_syntax, field.default_text, field.help));
  }
  return keywords;
}

std::shared_ptr<ThresholdGrid> grid_of(
    const py::array_t<float, py::array::f_style | py::array::forcecast>& thresholds,
    const Vec3& spacing, const Vec3& origin) {
  if (thresholds.ndim() != 3) raise(PyExc_ValueError, "A grid of errors has three axes.");
  auto grid = std::make_shared<ThresholdGrid>();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    grid->dims[axis] = static_cast<std::int32_t>(thresholds.shape(static_cast<py::ssize_t>(axis)));
    grid->index_to_world.columns[axis] = {0, 0, 0};
    grid->index_to_world.columns[axis][axis] = spacing[axis];
  }
  grid->index_to_world.translation = origin;
  grid->thresholds.assign(thresholds.data(), thresholds.data() + thresholds.size());
  return grid;
}

// ---- the connection

struct Step {
  CommittedStepPtr committed;
  std::string empty_text;  // Why there is no triangle; empty where there are some.
  py::object mesh;
};

// One request at a time: another one ends a stream that runs. Used by any number of threads, one
// after the other.
class Connection {
 public:
  Connection(const std::string& url, std::string token, std::string ca, bool insecure,
             double timeout)
      : server_(argument(parse_server_url(url))) {
    if (!(timeout > 0)) raise(PyExc_ValueError, "timeout must be above 0 seconds.");
    const double limited = std::min(timeout, 1e9);
    ClientOptions options{.timeout = std::chrono::milliseconds(std::llround(1000 * limited)),
                          .agent = "multitetra-python/" MULTITETRA_VERSION,
                          .token = std::move(token),
                          .trust = {.ca_file = std::move(ca), .insecure = insecure},
                          .interrupt = has_signal};
    client_.emplace(value_of(unlocked([&] { return Client::connect(server_, options); })));
  }

  ~Connection() {
    const py::error_scope error;
    disconnect();
  }

  void close() {
    disconnect();
    if (PyErr_Occurred() != nullptr) throw py::error_already_set();
  }

  std::vector<DatasetInfo> datasets() {
    infos_ = ask([](Client& client) { return client.list_datasets(); });
    return infos_;
  }

  DatasetInfo info(const std::string& name) {
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

  EstimateReply estimate(const std::string& dataset, const IsosurfaceRequest& request) {
    return ask([&](Client& client) { return client.estimate(dataset, request); });
  }

  std::vector<IsosurfaceRequest> share_budget(const std::string& dataset,
                                              std::vector<IsosurfaceRequest> requests) {
    argument(check_shared_budget(requests));
    ask([&](Client& client) { return client.share_budget(dataset, requests); });
    return requests;
  }

  SliceReply slice(const std::string& dataset, const SliceRequest& request) {
    return ask([&](Client& client) { return client.slice(dataset, request); });
  }

  std::vector<ProbedPlace> probe(const std::string& dataset, const ProbeRequest& request) {
    return ask([&](Client& client) { return client.probe(dataset, request); }).places;
  }

  // Begins a stream and returns its number.
  std::uint64_t open(const std::string& dataset, const IsosurfaceRequest& request, bool final_only,
                     bool display, const std::optional<ScalarRequest>& scalars) {
    OpenStream open{.dataset = dataset, .request = request, .scalars = scalars};
    if (display) open.use = MeshUse::kDisplay;
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

  // None after the final step.
  std::optional<Step> next(std::uint64_t stream) {
    const auto step =
        value_of(unlocked([this, stream]() -> ClientResult<std::optional<FetchedStep>> {
          if (stream != streams_) {
            return fail(ErrorSource::kServer,
                        {ErrorCode::kCancelled,
                         "Another request on this connection has ended this stream."});
          }
          if (!fetch_) return std::nullopt;
          auto next = fetch_->next();
          if (!next) is_lost_ |= next.error().source != ErrorSource::kServer;
          if (!next || !*next) fetch_.reset();
          return next;
        }));
    if (!step) return std::nullopt;
    const LatticeMesh& mesh = step->step->mesh;
    std::string empty_text;
    if (mesh.triangles.empty()) empty_text = empty_surface_text(open_request_, open_info_);
    return Step{
        step->step, std::move(empty_text),
        mesh_of(mesh, grid_to_world(open_info_), mesh_distance_bound(step->step->begin, open_info_),
                is_full_resolution(step->step->begin))};
  }

  // Stops the stream if it is the one that runs.
  void leave(std::uint64_t stream) {
    unlocked([this, stream] {
      if (stream == streams_) stop_stream();
    });
    if (PyErr_Occurred() != nullptr) throw py::error_already_set();
  }

 private:
  // Runs what may wait, without the GIL.
  template <typename Operation>
  std::invoke_result_t<const Operation&> unlocked(const Operation& operation) {
    const py::gil_scoped_release release;
    const std::scoped_lock lock(mutex_);
    return operation();
  }

  void disconnect() {
    unlocked([this] {
      fetch_.reset();
      client_.reset();
    });
  }

  void stop_stream() {
    if (!fetch_) return;
    is_lost_ |= !fetch_->cancel().has_value();
    fetch_.reset();
  }

  // Ends a stream that runs, and reconnects where the connection was lost.
  ClientResult<void> free_client() {
    if (!client_) {
      return fail(ErrorSource::kNetwork, {ErrorCode::kUnavailable, "The connection is closed."});
    }
    ++streams_;
    stop_stream();
    if (!is_lost_) return {};
    auto connected = client_->reconnect();
    is_lost_ = !connected.has_value();
    return connected;
  }

  template <typename Query, typename Answer = std::invoke_result_t<const Query&, Client&>>
  typename Answer::value_type ask(const Query& query) {
    return value_of(unlocked([&]() -> Answer {
      if (auto free = free_client(); !free) return tl::unexpected(free.error());
      Answer answer = query(*client_);
      if (!answer) is_lost_ |= answer.error().source != ErrorSource::kServer;
      return answer;
    }));
  }

  const Endpoint server_;
  std::vector<DatasetInfo> infos_;
  // The dataset of the last stream,
  DatasetInfo open_info_;
  IsosurfaceRequest open_request_;  // and its request.
  std::mutex mutex_;                // Guards what follows.
  std::uint64_t streams_ = 0;       // Requests so far; the last one may be a stream.
  std::optional<Client> client_;    // None: closed.
  DecodedTileCache tiles_;
  std::optional<Fetch> fetch_;  // The stream that runs.
  bool is_lost_ = false;
};

// ---- what Python sees

void define_requests(py::module_& module) {
  py::class_<ThresholdGrid, std::shared_ptr<ThresholdGrid>>(module, "ThresholdGrid");
  py::class_<IsosurfaceRequest>(module, "IsosurfaceRequest");
  py::class_<ScalarRequest>(module, "ScalarRequest");
  module.def("surface_request", &surface_request);
  module.def("request_keywords", &request_keywords);
  module.def("check_one_world", &check_one_world);
  module.def("grid", &grid_of, "thresholds"_a, "spacing"_a = Vec3{1, 1, 1},
             "origin"_a = Vec3{0, 0, 0},
             "Errors at the samples of an array (x, y, z), each for the voxel around it; NaN: none "
             "there.");
}

// "<Dataset head: 256 x 256 x 124 u16, spacing 0.94 x 0.94 x 1.5 mm, values 0 to 2766>"
std::string text_of_dataset(const DatasetInfo& info) {
  const auto joined = [](const auto& numbers) {
    std::string text;
    for (const auto number : numbers) {
      text += (text.empty() ? "" : " x ") + rounded_text(static_cast<double>(number));
    }
    return text;
  };
  const auto with_unit = [](const std::string& unit) { return unit.empty() ? "" : " " + unit; };
  return "<Dataset " + info.name + ": " + joined(info.dims) + " " + std::string(name(info.type)) +
         ", spacing " + joined(info.spacing) + with_unit(info.meaning.length_unit) + ", values " +
         rounded_text(info.min) + " to " + rounded_text(info.max) +
         with_unit(info.meaning.value_unit) + ">";
}

double affine_entry(const Affine& map, py::ssize_t row, py::ssize_t column) {
  if (row == 3) return column == 3 ? 1 : 0;
  const auto r = static_cast<std::size_t>(row);
  return column == 3 ? map.translation[r] : map.columns[static_cast<std::size_t>(column)][r];
}

void define_datasets(py::module_& module) {
  py::class_<Label>(module, "Label")
      .def_readonly("value", &Label::value)
      .def_readonly("name", &Label::name)
      .def_readonly("color", &Label::color);
  py::class_<LabelExtent>(module, "LabelExtent")
      .def_readonly("samples", &LabelExtent::samples, "With the label's value in its label map.")
      .def_property_readonly(
          "box",
          [](const LabelExtent& extent) -> py::object {
            if (!extent.place) return py::none();
            return py::make_tuple(extent.place->least, extent.place->greatest);
          },
          "The least and the greatest index of these samples; None: unknown.")
      .def_property_readonly(
          "centroid",
          [](const LabelExtent& extent) -> py::object {
            return extent.place ? py::cast(extent.place->centroid) : py::none();
          },
          "Their mean index; None: unknown.");
  py::class_<SeriesMember>(module, "SeriesMember")
      .def_readonly("series", &SeriesMember::series)
      .def_readonly("field", &SeriesMember::field)
      .def_readonly("time", &SeriesMember::time)
      .def_readonly("time_unit", &SeriesMember::time_unit)
      .def_readonly("label", &SeriesMember::label);
  py::class_<DatasetInfo>(module, "DatasetInfo")
      .def_readonly("name", &DatasetInfo::name)
      .def_readonly("label_extent", &DatasetInfo::label_extent)
      .def("__repr__", &text_of_dataset)
      .def_readonly("dims", &DatasetInfo::dims)
      .def_property_readonly(
          "shape",
          [](const DatasetInfo& info) {
            return py::make_tuple(info.dims[0], info.dims[1], info.dims[2]);
          },
          "Samples along x, y and z.")
      .def_property_readonly(
          "affine",
          [](const DatasetInfo& info) {
            py::array_t<double> affine({4, 4});
            auto at = affine.mutable_unchecked<2>();
            for (py::ssize_t row = 0; row < 4; ++row) {
              for (py::ssize_t column = 0; column < 4; ++column) {
                at(row, column) = affine_entry(info.index_to_world, row, column);
              }
            }
            return affine;
          },
          "(4, 4): world coordinates of a sample are affine @ [x, y, z, 1].")
      .def_property_readonly(
          "unit", [](const DatasetInfo& info) { return info.meaning.length_unit; },
          "The unit of spacing and world coordinates; empty if unknown.")
      .def_property_readonly("type", [](const DatasetInfo& info) { return name(info.type); })
      .def_readonly("spacing", &DatasetInfo::spacing)
      .def_property_readonly(
          "index_to_world",
          [](const DatasetInfo& info) {
            const auto& [columns, translation] = info.index_to_world;
            return rows_of<double>(std::array{columns[0], columns[1], columns[2], translation});
          },
          "(4, 3): the world's steps along x, y and z, and the first sample's place.")
      .def_property_readonly("space",
                             [](const DatasetInfo& info) { return name(info.meaning.space); })
      .def_property_readonly("length_unit",
                             [](const DatasetInfo& info) { return info.meaning.length_unit; })
      .def_property_readonly("value_unit",
                             [](const DatasetInfo& info) { return info.meaning.value_unit; })
      .def_readonly("min", &DatasetInfo::min)
      .def_readonly("max", &DatasetInfo::max)
      .def_readonly("void_samples", &DatasetInfo::void_samples)
      .def_readonly("outside", &DatasetInfo::outside)
      .def_readonly("margin", &DatasetInfo::margin)
      .def_readonly("grid_exponent", &DatasetInfo::grid_exponent)
      .def_property_readonly(
          "histogram",
          [](const DatasetInfo& info) {
            return py::make_tuple(info.histogram.low, info.histogram.high, info.histogram.counts);
          },
          "(low, high, counts): bins of equal width between low and high.")
      .def_readonly("suggested_isovalues", &DatasetInfo::suggested_isovalues)
      .def_readonly("member", &DatasetInfo::member);
}

template <typename Member>
auto of_begin(Member StepBegin::*member) {
  return [member](const Step& step) { return step.committed->begin.*member; };
}

void define_answers(py::module_& module) {
  py::class_<EstimateReply>(module, "Estimate", "About how large a surface will be.")
      .def_readonly("triangles", &EstimateReply::triangles)
      .def_readonly("bytes", &EstimateReply::bytes)
      .def_readonly("error_world", &EstimateReply::threshold_world,
                    "The largest that is allowed anywhere.");
  py::class_<SliceReply>(module, "SampledSlice")
      .def_readonly("sample_spacing", &SliceReply::sample_spacing,
                    "1, or 8 where every eighth sample was used.")
      .def_property_readonly(
          "values",
          [](const SliceReply& slice) {
            static_assert(std::endian::native == std::endian::little);
            return py::array(py::dtype::of<float>(), {slice.height, slice.width},
                             slice.values->data());
          },
          "(height, width) float32, NaN without a field.");
  py::class_<ProbedPlace>(module, "ProbedPlace")
      .def_property_readonly("world",
                             [](const ProbedPlace& p) { return py::array(py::cast(p.world)); })
      .def_property_readonly("index",
                             [](const ProbedPlace& p) { return py::array(py::cast(p.index)); })
      .def_readonly("value", &ProbedPlace::value, "None without a field.")
      .def_property_readonly(
          "gradient",
          [](const ProbedPlace& p) -> py::object {
            if (!p.gradient) return py::none();
            return py::array(py::cast(*p.gradient));
          },
          "(3,), by world unit; None without a field.");
  py::class_<Step>(module, "Step", "A complete surface that passed all checks.")
      .def_property_readonly("number", of_begin(&StepBegin::step))
      .def_property_readonly("is_final", of_begin(&StepBegin::is_final))
      .def_property_readonly("error_bound_world", of_begin(&StepBegin::error_bound_world),
                             "The bound of the distance to the full surface, where spacing is 1.")
      .def_property_readonly("spacing", of_begin(&StepBegin::finest_spacing),
                             "The spacing of samples that a preview uses; a preview has no bound. "
                             "Else 1.")
      .def_readonly("mesh", &Step::mesh)
      .def_readonly("empty_text", &Step::empty_text, "Why there is no triangle; else empty.")
      .def_property_readonly(
          "digest", [](const Step& step) { return step.committed->end.digest.hex(); },
          "The digest of all triangles, as in reports of multitetra-client.")
      .def_property_readonly(
          "border_edges", [](const Step& step) { return step.committed->topology.border_edges; },
          "Edges of one triangle, all of them where the data ends.")
      .def_property_readonly(
          "euler_characteristic",
          [](const Step& step) { return step.committed->topology.euler_characteristic; })
      .def_property_readonly("components",
                             [](const Step& step) { return step.committed->topology.components; })
      .def_property_readonly(
          "preserves_topology",
          [](const Step& step) { return preserves_topology(step.committed->begin); },
          "Whether the topology is that of the full-resolution surface.")
      .def_property_readonly("tiles_received",
                             [](const Step& step) { return step.committed->end.tiles_sent; })
      .def_property_readonly("payload_bytes",
                             [](const Step& step) { return step.committed->end.payload_bytes; })
      .def_property_readonly(
          "scalar_deviation",
          [](const Step& step) { return step.committed->largest_scalar_deviation; },
          "How far colors between vertices may be off, in values of color_by.");
}

void define_connection(py::module_& module) {
  py::class_<Connection>(module, "Connection")
      .def(py::init<const std::string&, std::string, std::string, bool, double>())
      .def("close", &Connection::close)
      .def("datasets", &Connection::datasets)
      .def("info", &Connection::info)
      .def("estimate", &Connection::estimate)
      .def("share_budget", &Connection::share_budget)
      .def("slice",
           [](Connection& connection, const std::string& dataset, const std::string& coordinates,
              const Vec3& origin, const Vec3& right, const Vec3& down, std::uint32_t width,
              std::uint32_t height, const std::string& interpolation, const std::string& detail) {
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
           [](Connection& connection, const std::string& dataset, std::vector<Vec3> places,
              const std::string& coordinates) {
             return connection.probe(
                 dataset, {.coordinates = word(coordinate_system_from(coordinates), "coordinates",
                                               coordinates),
                           .places = std::move(places)});
           })
      .def("open", &Connection::open)
      .def("next", &Connection::next)
      .def("leave", &Connection::leave);
}

PyObject* exception_class(py::module_& module, const char* name, const char* what) {
  const std::string full = std::string("multitetra.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(full.c_str(), what, nullptr, nullptr);
  if (type == nullptr) throw py::error_already_set();
  module.attr(name) = py::handle(type);
  return type;
}

}  // namespace
}  // namespace multitetra

PYBIND11_MODULE(_client, module) {
  using namespace multitetra;
  module.attr("__version__") = MULTITETRA_VERSION;
  module.def("save_mesh", &save_mesh);
  server_error =
      exception_class(module, "ServerError",
                      "The server refused the request; `code` is the name of its ErrorCode.");
  check_error = exception_class(module, "CheckError", "A reply contradicts itself or the request.");
  define_requests(module);
  define_datasets(module);
  define_answers(module);
  define_connection(module);
}
