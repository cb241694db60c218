// Measures how long a request's final step takes until it is complete and checked at the client, by
// error, for isovalues never requested before: requested alone, as `fetch -o` does, and after the
// previews of a stream that keeps its mesh; each also embedded. Prints Markdown.
//
//   final_steps_bench [--threads 2] [--errors 0.5,1,2,4] [--runs 1] head.mtd 500.5 -- female.mtd -300.5 300.5
#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <tbb/global_control.h>

#include "server/dataset/dataset.hpp"
#include "tests/bench/measured_stream.hpp"

namespace multitetra {
namespace {

struct Arguments {
  std::size_t threads = 2;
  std::vector<double> errors = {0.5, 1, 2, 4};
  int runs = 1;  // The minimum counts.
};

struct FinalStep {
  double seconds = 0;
  std::size_t triangles = 0;
};

FinalStep final_step(const std::shared_ptr<const SurfaceExtractor>& extractor,
                     const IsosurfaceRequest& request, StepPolicy steps, const Arguments& with) {
  FinalStep least;
  for (int run = 0; run < with.runs; ++run) {
    MeasuredServer server(extractor, with.threads, {}, {.name = "", .steps = steps});
    IsosurfaceRequest neighbour = request;  // Trains the server's estimates.
    neighbour.isovalue *= 1.01;
    neighbour.error = 2;
    (void)server.stream(neighbour);
    const MeasuredStream stream = server.stream(request);
    const FetchedStep& last = stream.back().fetched;
    if (!last.step->begin.is_final) throw std::runtime_error("a stream has no final step");
    if (run == 0 || last.seconds < least.seconds) least.seconds = last.seconds;
    least.triangles = last.step->mesh.triangles.size();
  }
  return least;
}

void print_rows(const std::string& file, double isovalue, const Arguments& with) {
  const auto extractor = std::make_shared<const SurfaceExtractor>(open_dataset(file));
  for (const double error : with.errors) {
    std::printf("| %s, %g | %g |", extractor->dataset().info.name.c_str(), isovalue, error);
    for (const bool embedded : {false, true}) {
      const IsosurfaceRequest request = {
          .isovalue = isovalue, .error = error, .simplify = true, .intersection_free = embedded};
      const FinalStep alone = final_step(extractor, request, StepPolicy::kFinalOnly, with);
      const FinalStep after = final_step(extractor, request, StepPolicy::kProgressive, with);
      std::printf(" %.2f s | %.2f s | %zu |", alone.seconds, after.seconds, alone.triangles);
    }
    std::puts("");
    std::fflush(stdout);
  }
}

int main_with(const std::vector<std::string>& words) {
  Arguments arguments;
  std::size_t i = 0;
  for (; i + 1 < words.size() && words[i].starts_with("--"); i += 2) {
    if (words[i] == "--threads") {
      arguments.threads = std::stoul(words[i + 1]);
    } else if (words[i] == "--runs") {
      arguments.runs = std::stoi(words[i + 1]);
    } else if (words[i] == "--errors") {
      arguments.errors.clear();
      std::istringstream list(words[i + 1]);
      for (std::string word; std::getline(list, word, ',');) {
        arguments.errors.push_back(std::stod(word));
      }
    } else {
      throw std::runtime_error("unknown option " + words[i]);
    }
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, arguments.threads);
  std::puts(
      "| volume, isovalue | error | final step alone | after previews | triangles | embedded: "
      "alone "
      "| after previews | triangles |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
  while (i < words.size()) {
    const std::string file = words[i++];
    for (; i < words.size() && words[i] != "--"; ++i) {
      print_rows(file, std::stod(words[i]), arguments);
    }
    ++i;
  }
  return 0;
}

}  // namespace
}  // namespace multitetra

int main(int argc, char** argv) {
  try {
    return multitetra::main_with({argv + 1, argv + argc});
  } catch (const std::exception& failure) {
    std::cerr << "final_steps_bench: " << failure.what() << "\n";
    return 1;
  }
}
