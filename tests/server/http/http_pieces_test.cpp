// Parsing HTTP requests, without a network.
#include <gtest/gtest.h>

#include "common/base/percent_encoded.hpp"
#include "server/http/conditions.hpp"
#include "server/http/http_request.hpp"
#include "server/http/media.hpp"
#include "server/http/origin.hpp"
#include "server/http/target.hpp"
#include "server/routes/detail/mesh_query.hpp"
#include "server/routes/path_pattern.hpp"

namespace multitetra {
namespace {

// ---- requests

constexpr std::string_view kTwoRequests =
    "GET /a HTTP/1.1\r\nHost: x\r\n\r\nHEAD /b?c=d HTTP/1.1\r\nHost: y\r\nRange: bytes=0-1\r\n\r\n";

TEST(RequestReader, ReadsRequestsFromAnySplitOfTheirBytes) {
  for (std::size_t portion : {1U, 2U, 7U, 1000U}) {
    RequestReader reader(1024);
    std::vector<HttpRequest> requests;
    for (std::size_t at = 0; at < kTwoRequests.size(); at += portion) {
      reader.feed(kTwoRequests.substr(at, portion));
      for (auto next = reader.next(); next.value(); next = reader.next()) {
        requests.push_back(std::move(**next));
      }
    }
    ASSERT_EQ(requests.size(), 2U) << portion;
    EXPECT_EQ(requests[0].target(), "/a");
    EXPECT_EQ(requests[1].method(), http::verb::head);
    EXPECT_EQ(field(requests[1], http::field::range), "bytes=0-1");
    EXPECT_FALSE(reader.is_inside());
  }
}

int status_of(std::string_view bytes) {
  RequestReader reader(256);
  reader.feed(bytes);
  const auto request = reader.next();
  return request ? (*request ? 200 : 0) : request.error().status;
}

TEST(RequestReader, RejectsInvalidRequests) {
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: x\r\n\r\n"), 200);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: x\r\n"), 0);
  EXPECT_EQ(status_of("\x16\x03\x01 no HTTP at all\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/3.0\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nno colon\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET /" + std::string(300, 'a')), 431);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nA: " + std::string(300, 'a') + "\r\n\r\n"), 431);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nContent-Length: 5\r\n\r\nhello"), 413);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"), 413);
  EXPECT_EQ(status_of("POST / HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n"), 200);
}

// A proxy in front might read a body where the server reads the next request (request smuggling).
TEST(RequestReader, RejectsEveryTransferEncoding) {
  for (const char* coding : {"xchunked", "identity", "gzip", "chunked, identity", ""}) {
    const int status = status_of(
        "GET / HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: " + std::string(coding) + "\r\n\r\n");
    EXPECT_GE(status, 400) << coding;
  }
}

TEST(RequestReader, RequiresExactlyOneHost) {
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"), 400);
  EXPECT_EQ(status_of("GET / HTTP/1.0\r\n\r\n"), 200) << "did not know it";
  EXPECT_EQ(status_of("GET / HTTP/1.0\r\nHost: a\r\nHost: a\r\n\r\n"), 400);
}

TEST(RequestReader, BuffersLittleMoreThanItsLimit) {
  RequestReader reader(256);
  for (int i = 0; i < 1000; ++i) {
    reader.feed("a");
    if (!reader.next()) break;
    EXPECT_LE(reader.rest().size(), 257U);
  }
  EXPECT_FALSE(reader.next());
}

// ---- targets and routes

TEST(Target, SplitsBeforeDecoding) {
  const Target target = parse_target("/v1/a%2Fb/c%20d?x=%26&y&region=ball:1,2,3,4=0.5").value();
  EXPECT_EQ(target.path, (std::vector<std::string>{"v1", "a/b", "c d"}));
  EXPECT_EQ(target.query, (std::vector<std::pair<std::string, std::string>>{
                              {"x", "&"}, {"y", ""}, {"region", "ball:1,2,3,4=0.5"}}));
  EXPECT_TRUE(parse_target("/").value().path.empty());
  EXPECT_EQ(parse_target("http://example.org:80/v1/a?b").value().raw_path, "/v1/a");
  EXPECT_TRUE(parse_target("https://example.org").value().path.empty());
}

TEST(Target, IsTheSameWithAndWithoutTheBasePath) {
  EXPECT_EQ(without_base_path("/volumes/v1/datasets?x=1", "/volumes"), "/v1/datasets?x=1");
  EXPECT_EQ(without_base_path("/volumes/", "/volumes"), "/");
  EXPECT_EQ(without_base_path("/v1/datasets", "/volumes"), "/v1/datasets");
  EXPECT_EQ(without_base_path("/volumes2/x", "/volumes"), "/volumes2/x");
  EXPECT_EQ(without_base_path("/volumes", "/volumes"), "/volumes");
  EXPECT_EQ(without_base_path("/x", ""), "/x");
  EXPECT_TRUE(is_base_path("/volumes?x=1", "/volumes"));
  EXPECT_FALSE(is_base_path("/volumes/", "/volumes"));
  EXPECT_FALSE(is_base_path("", ""));
}

TEST(Target, NormalizesAndValidatesBasePaths) {
  for (const char* text : {"/volumes", "volumes/", "/volumes/"}) {
    EXPECT_EQ(parse_base_path(text).value(), "/volumes") << text;
  }
  EXPECT_EQ(parse_base_path("/a/b-c").value(), "/a/b-c");
  EXPECT_EQ(parse_base_path("/").value(), "");
  EXPECT_EQ(parse_base_path("").value(), "");
  for (const char* text :
       {"/a b", "/a?b", "/a\r\nSet-Cookie: x", "https://site/volumes", "/volumes//"}) {
    EXPECT_FALSE(parse_base_path(text)) << text;
  }
}

TEST(Target, RejectsInvalidEncoding) {
  for (const auto* bad : {"", "*", "ftp://x/", "a", "/%", "/%4", "/%zz", "/?a=%", "/?%=a"}) {
    EXPECT_FALSE(parse_target(bad)) << bad;
  }
  EXPECT_EQ(percent_decoded("%41%4a+").value(), "AJ+");
}

std::optional<PathValues> values(const char* pattern, std::string_view target) {
  return PathPattern(pattern).match(parse_target(target).value().path);
}

TEST(PathPattern, MatchesEverySegment) {
  EXPECT_EQ(values("/livez", "/livez?x=1"), PathValues{});
  EXPECT_EQ(values("/v1/datasets/{name}/slice", "/v1/datasets/a%20b/slice"), PathValues{"a b"});
  for (const auto* other :
       {"/", "/v1/datasets/a", "/v1/datasets/a/slice/b", "/v1/datasets/a/Slice"}) {
    EXPECT_FALSE(values("/v1/datasets/{name}/slice", other)) << other;
  }
}

TEST(PathPattern, TakesTheRestOfThePath) {
  EXPECT_EQ(values("/v1/3dtiles/{path...}", "/v1/3dtiles/a/iso/%2F"),
            (PathValues{"a", "iso", "/"}));
  EXPECT_EQ(values("/v1/3dtiles/{path...}", "/v1/3dtiles"), PathValues{});
  EXPECT_EQ(values("/{path...}", "/"), PathValues{});
  EXPECT_FALSE(values("/v1/3dtiles/{path...}", "/v1"));
}

TEST(PathPattern, FindsTheTokenInAPath) {
  const auto found = path_with_token(parse_target("/v1/token/a%20b/3dtiles/x").value());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->token, "a b");
  EXPECT_EQ(found->path, (std::vector<std::string>{"v1", "3dtiles", "x"}));
  for (const auto* none : {"/v1/token/a", "/v1/3dtiles/token/a", "/v1/t%6fken/a/3dtiles/x"}) {
    EXPECT_FALSE(path_with_token(parse_target(none).value())) << none;
  }
}

// ---- queries

MeshQuery query_of(std::string_view query) {
  return parse_mesh_query(parse_target("/?" + std::string(query)).value().query).value();
}

TEST(MeshQuery, HasEveryOptionOfTheCommandLine) {
  const auto [query, format] = query_of(
      "isovalue=-3e%2B2&error=0.25&unit=world&bound=paper&topology_rule=paper&topology_tolerance=2&"
      "lattice=4&region=ball:1,2,3,4=0.5&region=box:0,0,0,1,1,1=0&region_coordinates=index&"
      "combine=minimum&max_triangles=1000&max_bytes=2000&simplify=off&intersection_free=true&"
      "normals=8&"
      "coordinates=index&"
      "format=stl&"
      "view=eye=1,2,3,fov=40,height=1080,pixels=1");
  EXPECT_EQ(query.isovalues, std::vector<double>{-300.0});
  EXPECT_EQ(query.request.error, 0.25);
  EXPECT_EQ(query.request.unit, ErrorUnit::kWorld);
  EXPECT_EQ(query.request.error_measure, ErrorMeasure::kPaper);
  EXPECT_EQ(query.request.topology_rule, TopologyRule::kPaper);
  EXPECT_EQ(query.request.topology_tolerance, 2);
  EXPECT_EQ(query.request.lattice_resolution, 4);
  EXPECT_EQ(query.request.thresholds.regions.size(), 2U);
  EXPECT_EQ(query.request.thresholds.coordinates, CoordinateSystem::kIndex);
  EXPECT_EQ(query.request.thresholds.combination, Combination::kMinimum);
  EXPECT_TRUE(query.request.thresholds.view);
  EXPECT_EQ(query.request.max_triangles, 1000U);
  EXPECT_EQ(query.request.max_bytes, 2000U);
  EXPECT_FALSE(query.request.simplify);
  EXPECT_TRUE(query.request.intersection_free);
  EXPECT_EQ(query.request.normal_bits, 8);
  EXPECT_EQ(query.coordinates, CoordinateSystem::kIndex);
  EXPECT_EQ(format, MeshFormat::kStl);
}

TEST(MeshQuery, HasTheDefaultsOfTheCommandLine) {
  const auto [query, format] = query_of("");
  EXPECT_EQ(query.request, (IsosurfaceRequest{.error = 0.25, .simplify = true}));
  EXPECT_TRUE(query.isovalues.empty());
  EXPECT_EQ(query.coordinates, CoordinateSystem::kWorld);
  EXPECT_FALSE(format);
}

TEST(MeshQuery, NamesTheInvalidParameter) {
  for (const auto& [query, named] : {std::pair{"isovalue=x", "isovalue"},
                                     {"error=1,5", "error"},
                                     {"error=1&error=2", "error"},
                                     {"quality=best", "quality"},
                                     {"unit=mm", "unit"},
                                     {"lattice=1e3", "lattice"},
                                     {"max_triangles=-1", "max_triangles"},
                                     {"region=cube:1=2", "region"},
                                     {"format=vtk", "format"},
                                     {"isoval=3", "isoval"},
                                     {"threshold_grid=/etc/passwd", "threshold_grid"},
                                     {"simplify=1", "simplify"},
                                     {"normals=", "normals"}}) {
    const auto parsed = parse_mesh_query(parse_target("/?" + std::string(query)).value().query);
    ASSERT_FALSE(parsed) << query;
    EXPECT_NE(parsed.error().text.find(named), std::string::npos) << parsed.error().text;
  }
}

TEST(MeshQuery, ValidatesLikeAWireRequest) {
  DatasetInfo info;
  info.name = "a";
  EXPECT_FALSE(requests_for(query_of("").surface, info));
  info.suggested_isovalues = {7};
  EXPECT_EQ(requests_for(query_of("").surface, info).value().front().isovalue, 7);
  EXPECT_FALSE(requests_for(query_of("error=-1").surface, info));
  EXPECT_FALSE(requests_for(query_of("isovalue=nan").surface, info));
  EXPECT_FALSE(requests_for(query_of("lattice=9").surface, info));
  EXPECT_FALSE(requests_for(query_of("error=1&quality=fine").surface, info));
  EXPECT_EQ(requests_for(query_of("quality=draft").surface, info).value().front().error, 2);
}

// ---- conditions and ranges

TEST(Conditions, MatchATagInAListOrAnyTag) {
  EXPECT_TRUE(matches_tag("\"a\"", "\"a\""));
  EXPECT_TRUE(matches_tag("\"b\" , W/\"a\"", "\"a\""));
  EXPECT_TRUE(matches_tag("*", "\"a\""));
  EXPECT_FALSE(matches_tag("", "\"a\""));
  EXPECT_FALSE(matches_tag("\"ab\", a", "\"a\""));
  EXPECT_FALSE(matches_tag("", ""));
}

TEST(Ranges, ServeASingleValidRange) {
  const auto range = [](std::string_view field) { return range_of(field, "", "\"t\"", 100); };
  EXPECT_EQ(range("bytes=0-0"), (RangeOutcome{ByteRange{0, 1}}));
  EXPECT_EQ(range("bytes=10-19"), (RangeOutcome{ByteRange{10, 10}}));
  EXPECT_EQ(range("bytes=90-"), (RangeOutcome{ByteRange{90, 10}}));
  EXPECT_EQ(range("bytes=90-99999999999999999999999"), (RangeOutcome{ByteRange{90, 10}}));
  EXPECT_EQ(range("bytes=-7"), (RangeOutcome{ByteRange{93, 7}}));
  EXPECT_EQ(range("bytes=-200"), (RangeOutcome{ByteRange{0, 100}}));
  EXPECT_EQ(range("bytes=100-"), RangeOutcome{RangeNotSatisfiable{}});
  EXPECT_EQ(range("bytes=-0"), RangeOutcome{RangeNotSatisfiable{}});
  for (const auto* all : {"", "bytes=", "bytes=-", "bytes=a-b", "bytes=5-4", "bytes=0-1,3-4",
                          "lines=0-1", "bytes=1", "bytes=0x1-2"}) {
    EXPECT_EQ(range(all), RangeOutcome{FullContent{}}) << all;
  }
  EXPECT_EQ(range_of("bytes=0-", "", "\"t\"", 0), RangeOutcome{RangeNotSatisfiable{}});
}

TEST(Ranges, AreIgnoredWhenTheContentChanged) {
  EXPECT_EQ(range_of("bytes=0-0", "\"t\"", "\"t\"", 9), (RangeOutcome{ByteRange{0, 1}}));
  EXPECT_EQ(range_of("bytes=0-0", "\"s\"", "\"t\"", 9), RangeOutcome{FullContent{}});
  EXPECT_EQ(range_of("bytes=0-0", "W/\"t\"", "\"t\"", 9), RangeOutcome{FullContent{}});
}

// ---- formats and origins

TEST(Media, HonoursTheClientsPreference) {
  EXPECT_EQ(accepted_format(""), MeshFormat::kGlb);
  EXPECT_EQ(accepted_format("*/*"), MeshFormat::kGlb);
  EXPECT_EQ(accepted_format("text/html, model/stl"), MeshFormat::kStl);
  EXPECT_EQ(accepted_format("model/*;q=0.5, application/ply"), MeshFormat::kPly);
  EXPECT_EQ(accepted_format("model/gltf-binary;q=0, */*;q=0.1"), MeshFormat::kPly);
  EXPECT_EQ(accepted_format("text/html"), std::nullopt);
  EXPECT_EQ(accepted_format("*/*;q=0"), std::nullopt);
}

TEST(Origin, AllowsOwnAndListedOrigins) {
  EXPECT_TRUE(is_allowed_origin("", "h", {}));
  EXPECT_TRUE(is_allowed_origin("http://h:7480", "h:7480", {}));
  EXPECT_TRUE(is_allowed_origin("https://H", "h", {}));
  EXPECT_TRUE(is_allowed_origin("https://h", "h:443", {}));
  EXPECT_FALSE(is_allowed_origin("http://h:7481", "h:7480", {}));
  EXPECT_FALSE(is_allowed_origin("http://h.evil", "h", {}));
  EXPECT_FALSE(is_allowed_origin("null", "h", {}));
  EXPECT_FALSE(is_allowed_origin("http://", "", {}));
  EXPECT_TRUE(is_allowed_origin("https://a.example", "h", {"https://a.example"}));
  EXPECT_TRUE(is_allowed_origin("null", "h", {"*"}));
}

TEST(Origin, IsFormattedAsInBrowsers) {
  for (const char* good : {"*", "https://a.example", "http://localhost:8080", "http://[::1]:80",
                           "moz-extension://1b2c-3d"}) {
    EXPECT_TRUE(is_origin(good)) << good;
  }
  for (const char* bad : {"", "a.example", "https://", "https://a.example/", "https://a b", "*.a",
                          "https://a:port", "https://a.example/x", "//a", "https:/a"}) {
    EXPECT_FALSE(is_origin(bad)) << bad;
  }
}

TEST(Origin, MayReadAnswersOnlyIfAllowed) {
  EXPECT_EQ(cross_origin_fields("https://a", "h", {}, false), "");
  EXPECT_EQ(cross_origin_fields("https://b", "h", {"https://a"}, false), "Vary: Origin\r\n");
  const std::string allowed = cross_origin_fields("https://a", "h", {"https://a"}, true);
  EXPECT_NE(allowed.find("Access-Control-Allow-Origin: https://a\r\n"), std::string::npos);
  EXPECT_NE(allowed.find("Access-Control-Allow-Headers: Authorization"), std::string::npos);
}

}  // namespace
}  // namespace multitetra
