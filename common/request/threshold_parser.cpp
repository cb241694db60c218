#include "common/request/threshold_parser.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "common/base/parse_number.hpp"
#include "common/base/text.hpp"

namespace multitetra {
namespace {

constexpr std::string_view kRegionForms =
    "box:X0,Y0,Z0,X1,Y1,Z1=TAU, ball:X,Y,Z,R=TAU or halfspace:NX,NY,NZ,D=TAU";
constexpr std::string_view kViewForm =
    "eye=X,Y,Z,fov=DEGREES,height=PIXELS,pixels=TOLERANCE"
    "[,look=X,Y,Z,outside=TAU[,up=X,Y,Z][,aspect=RATIO]]";

std::string quoted(std::string_view word) { return "\"" + std::string(word) + "\""; }

tl::unexpected<Error> refuse(std::string_view what, std::string_view word, std::string problem,
                             std::string_view form) {
  return fail(ErrorCode::kInvalidArgument, "The " + std::string(what) + " " + quoted(word) + " " +
                                               std::move(problem) + "; write " + std::string(form) +
                                               ".");
}

// Returns the shape of `kind`. Requires the right number of numbers.
decltype(ThresholdRegion::shape) shape_of(std::string_view kind, const std::vector<double>& n) {
  if (kind == "ball") return BallShape{.center = {n[0], n[1], n[2]}, .radius = n[3]};
  if (kind == "halfspace") return HalfSpaceShape{.normal = {n[0], n[1], n[2]}, .offset = n[3]};
  return BoxShape{.low = {n[0], n[1], n[2]}, .high = {n[3], n[4], n[5]}};
}

using NamedNumbers = std::map<std::string_view, std::vector<double>>;

// The number of numbers of each part of a view.
const std::map<std::string_view, std::size_t> kViewParts = {
    {"eye", 3},  {"fov", 1}, {"height", 1}, {"pixels", 1},
    {"look", 3}, {"up", 3},  {"aspect", 1}, {"outside", 1}};

// Returns the numbers of each part of a view by name. All required parts are present.
Result<NamedNumbers> numbers_of_view(std::string_view word) {
  const auto wrong = [word](std::string problem) {
    return refuse("view", word, std::move(problem), kViewForm);
  };
  NamedNumbers given;
  std::string_view name;
  for (std::string_view part : split(word, ',')) {
    if (const std::size_t equals = part.find('='); equals != std::string_view::npos) {
      name = part.substr(0, equals);
      part.remove_prefix(equals + 1);
      if (!kViewParts.contains(name)) return wrong("has an unknown part " + quoted(name));
      if (given.contains(name)) return wrong("has " + quoted(name) + " twice");
    }
    const auto value = parse_number<double>(part);
    if (name.empty() || !value) return wrong("has " + quoted(part) + " instead of a number");
    given[name].push_back(*value);
  }
  for (const auto& [part, numbers] : given) {
    if (numbers.size() == kViewParts.at(part)) continue;
    return wrong("has " + std::to_string(numbers.size()) + " numbers for " + quoted(part) +
                 ", not " + std::to_string(kViewParts.at(part)));
  }
  for (const std::string_view part : {"eye", "fov", "height", "pixels"}) {
    if (!given.contains(part)) return wrong("lacks " + quoted(part));
  }
  for (const std::string_view part : {"up", "aspect", "outside"}) {
    if (!given.contains(part) || given.contains("look")) continue;
    return wrong("has " + quoted(part) + " without \"look\"");
  }
  if (given.contains("look") && !given.contains("outside")) {
    return wrong("has \"look\" without \"outside\"");
  }
  return given;
}

}  // namespace

Result<ThresholdRegion> parse_region(std::string_view word) {
  const auto wrong = [word](std::string problem) {
    return refuse("region", word, std::move(problem), kRegionForms);
  };
  const std::size_t colon = word.find(':');
  const std::string_view kind = word.substr(0, colon);
  if (colon == std::string_view::npos || (kind != "box" && kind != "ball" && kind != "halfspace")) {
    return wrong("does not begin with a shape");
  }
  const std::size_t equals = word.rfind('=');
  if (equals == std::string_view::npos) return wrong("has no threshold");
  const auto threshold = parse_number<double>(word.substr(equals + 1));
  if (!threshold) return wrong("has a threshold that is not a number");
  std::vector<double> numbers;
  for (const std::string_view part : split(word.substr(colon + 1, equals - colon - 1), ',')) {
    const auto value = parse_number<double>(part);
    if (!value) return wrong("has " + quoted(part) + " instead of a number");
    numbers.push_back(*value);
  }
  const std::size_t wanted = kind == "box" ? 6 : 4;
  if (numbers.size() != wanted) {
    return wrong("has " + std::to_string(numbers.size()) + " numbers before its threshold, not " +
                 std::to_string(wanted));
  }
  const ThresholdRegion region{.shape = shape_of(kind, numbers), .threshold = *threshold};
  if (const auto* box = std::get_if<BoxShape>(&region.shape)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (box->low[axis] <= box->high[axis]) continue;
      return wrong(std::string("has its low corner above its high corner along ") + "xyz"[axis]);
    }
  }
  return region;
}

Result<ThresholdView> parse_view(std::string_view word) {
  auto read = numbers_of_view(word);
  if (!read) return tl::unexpected(read.error());
  NamedNumbers& given = *read;
  const auto place = [&given](std::string_view name) {
    const std::vector<double>& n = given[name];
    return Vec3{n[0], n[1], n[2]};
  };
  ThresholdView view{.eye = place("eye"),
                     .field_of_view = given["fov"][0],
                     .height_pixels = given["height"][0],
                     .tolerance_pixels = given["pixels"][0]};
  if (!given.contains("look")) return view;
  view.frustum = Frustum{.look_at = place("look"), .outside = given["outside"][0]};
  const Vec3& look = view.frustum->look_at;
  if (given.contains("up")) {
    view.frustum->up = place("up");
  } else if (look[0] == view.eye[0] && look[1] == view.eye[1]) {
    // Looking straight along z, which is the default upward direction.
    view.frustum->up = {0, 1, 0};
  }
  if (given.contains("aspect")) view.frustum->aspect = given["aspect"][0];
  return view;
}

}  // namespace multitetra
