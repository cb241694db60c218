#include "tests/bench/volume_report.hpp"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "common/cli/human_units.hpp"

namespace multitetra {
namespace {

std::string fixed(double value, int decimals) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

std::string optional_ratio(const std::optional<double>& ratio) {
  return ratio ? fixed(*ratio, 2) : "-";
}

std::uint64_t voxels_of(const DatasetInfo& info) {
  std::uint64_t voxels = 1;
  for (const std::int32_t side : info.dims) voxels *= static_cast<std::uint64_t>(side);
  return voxels;
}

std::string facts_of(const VolumeReport& report) {
  const DatasetInfo& info = report.info;
  std::string text = info.name + ": " + std::to_string(info.dims[0]) + " x " +
                     std::to_string(info.dims[1]) + " x " + std::to_string(info.dims[2]) + " " +
                     std::string(name(info.type)) + ", isovalue " + human_number(report.isovalue) +
                     "; " + std::to_string(report.processors) + " processors\n";
  text += "  prepared file " + human_bytes(report.file_bytes) + ", " +
          fixed(report.overhead_bytes_per_voxel(), 3) +
          " bytes a voxel beyond the samples; opened in " + fixed(1000 * report.open_seconds, 2) +
          " ms\n";
  if (report.flying_edges.empty()) {
    text += "  NO COMPARISON with flying edges: built without VTK\n";
  }
  for (std::size_t i = 0; i < report.flying_edges.size(); ++i) {
    text += "  flying edges, requested " + std::to_string(report.threads[i]) +
            " threads: " + report.flying_edges[i] + "\n";
  }
  if (report.preview) {
    const BrickReads& reads = *report.preview;
    text += "  first preview reads sample bricks " + human_count(reads.sample_reads) +
            " times (there are " + human_count(reads.sample_bricks) + "), spectrum bricks " +
            human_count(reads.spectrum_reads) + " times (there are " +
            human_count(reads.spectrum_bricks) + ")\n";
  } else {
    text += "  NO PREVIEW: the grid is too small for one\n";
  }
  return text;
}

std::string header_of(const VolumeReport& report) {
  std::string header = "| volume | work | triangles |";
  std::string line = "| --- | --- | ---: |";
  for (const int threads : report.threads) {
    header += " median ms (least), threads " + std::to_string(threads) + " | to flying edges |";
    line += " ---: | ---: |";
  }
  if (report.threads.size() > 1) {
    header += " t(" + std::to_string(report.threads.front()) + ")/t(" +
              std::to_string(report.threads.back()) + ") |";
    line += " ---: |";
  }
  return header + "\n" + line + "\n";
}

std::string row_of(const VolumeReport& report, const Measurement& measurement) {
  std::string row = "| " + report.info.name + " | " + measurement.work + " | " +
                    human_count(measurement.triangles) + " |";
  for (std::size_t i = 0; i < report.threads.size(); ++i) {
    const Timing& timing = measurement.timings[i];
    row += " " + fixed(1000 * timing.median(), 1) + " (" + fixed(1000 * timing.least(), 1) +
           ") | " + optional_ratio(report.ratio(measurement, i)) + " |";
  }
  if (report.threads.size() > 1) row += " " + optional_ratio(report.speedup(measurement)) + " |";
  return row + "\n";
}

Json json_of(const VolumeReport& report, const Measurement& measurement) {
  Json json = {{"work", measurement.work}, {"triangles", measurement.triangles}};
  if (measurement.encoded_bytes > 0) json["encoded_bytes"] = measurement.encoded_bytes;
  for (std::size_t i = 0; i < report.threads.size(); ++i) {
    const Timing& timing = measurement.timings[i];
    const std::optional<double> ratio = report.ratio(measurement, i);
    json["timings"].push_back({{"threads", report.threads[i]},
                               {"median_seconds", timing.median()},
                               {"least_seconds", timing.least()},
                               {"ratio_to_flying_edges", ratio ? Json(*ratio) : Json(nullptr)}});
  }
  const std::optional<double> speedup = report.speedup(measurement);
  json["speedup"] = speedup ? Json(*speedup) : Json(nullptr);
  return json;
}

}  // namespace

double Timing::median() const {
  std::vector<double> sorted = seconds;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

double Timing::least() const { return *std::min_element(seconds.begin(), seconds.end()); }

double VolumeReport::overhead_bytes_per_voxel() const {
  const auto voxels = static_cast<double>(voxels_of(info));
  return static_cast<double>(file_bytes) / voxels - bytes_per_sample(info.type);
}

std::optional<double> VolumeReport::ratio(const Measurement& measurement, std::size_t index) const {
  if (flying_edges.empty()) return std::nullopt;
  return measurement.timings[index].median() / measurements.front().timings[index].median();
}

std::optional<double> VolumeReport::speedup(const Measurement& measurement) const {
  if (threads.size() < 2) return std::nullopt;
  return measurement.timings.front().median() / measurement.timings.back().median();
}

std::string table_of(const VolumeReport& report) {
  std::string text = facts_of(report) + header_of(report);
  for (const Measurement& measurement : report.measurements) text += row_of(report, measurement);
  return text;
}

Json json_of(const VolumeReport& report) {
  Json json = {{"volume", report.info.name},
               {"dims", report.info.dims},
               {"type", name(report.info.type)},
               {"isovalue", report.isovalue},
               {"processors", report.processors},
               {"file_bytes", report.file_bytes},
               {"overhead_bytes_per_voxel", report.overhead_bytes_per_voxel()},
               {"open_seconds", report.open_seconds},
               {"threads", report.threads},
               {"flying_edges", report.flying_edges},
               {"preview_reads", nullptr}};
  if (report.preview) {
    json["preview_reads"] = {{"sample_reads", report.preview->sample_reads},
                             {"sample_bricks", report.preview->sample_bricks},
                             {"spectrum_reads", report.preview->spectrum_reads},
                             {"spectrum_bricks", report.preview->spectrum_bricks}};
  }
  for (const Measurement& measurement : report.measurements) {
    json["measurements"].push_back(json_of(report, measurement));
  }
  return json;
}

}  // namespace multitetra
