#include "server/volume/formats/dicom/detail/dicom_moments.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <tuple>

#include "server/volume/formats/dicom/detail/dicom_elements.hpp"

namespace multitetra {
namespace {

using gdcm::Tag;

// The elements of files, followed by the first DimensionIndexValues of frames: of stacks, b-values
// and whatever else the file declares as a dimension (PS3.3 C.7.6.17).
constexpr std::array<std::array<std::uint16_t, 2>, 6> kTags = {{{0x0020, 0x0100},
                                                                {0x0020, 0x0012},
                                                                {0x0018, 0x1060},
                                                                {0x0018, 0x0081},
                                                                {0x0008, 0x0032},
                                                                {0x0008, 0x0033}}};
constexpr std::array<const char*, 4> kNames = {"TemporalPositionIdentifier", "AcquisitionNumber",
                                               "TriggerTime", "EchoTime"};
constexpr std::size_t kTemporalPosition = 0, kAcquisition = 1, kTrigger = 2, kEcho = 3;

using Elements = std::vector<std::size_t>;
using Values = std::vector<double>;

Values values_of(const DicomImage& image, const Elements& elements) {
  Values values;
  for (const std::size_t element : elements) values.push_back(image.moment[element]);
  return values;
}

// Whether the images at each position have the same values of these elements.
bool are_everywhere(const DicomPositions& positions, const Elements& elements) {
  const auto sorted_values = [&](const std::vector<DicomImage>& images) {
    std::vector<Values> values;
    for (const DicomImage& image : images) values.push_back(values_of(image, elements));
    std::sort(values.begin(), values.end());
    return values;
  };
  const std::vector<Values> first = sorted_values(positions.front());
  return std::all_of(positions.begin(), positions.end(),
                     [&](const auto& images) { return sorted_values(images) == first; });
}

}  // namespace

void set_moment(const gdcm::DataSet& file, DicomImage& image) {
  for (std::size_t i = 0; i < kTags.size(); ++i) {
    const std::vector<double> values = numbers_at(file, Tag(kTags[i][0], kTags[i][1]));
    if (!values.empty()) image.moment[i] = values[0];
  }
}

void set_moment_of_frame(const gdcm::DataSet& groups, DicomImage& image) {
  const auto set = [&](std::size_t element, const auto& values) {
    if (values.empty()) return;
    const auto value = static_cast<double>(values[0]);
    if (std::isfinite(value)) image.moment[element] = value;
  };
  with_item(groups, Tag(0x0020, 0x9111), [&](const gdcm::DataSet& content) {
    set(kTemporalPosition, binary_at<std::uint32_t>(content, Tag(0x0020, 0x9128)));
    set(kAcquisition, binary_at<std::uint16_t>(content, Tag(0x0020, 0x9156)));
    const std::vector<std::uint32_t> indices =
        binary_at<std::uint32_t>(content, Tag(0x0020, 0x9157));
    for (std::size_t i = 0; i < indices.size() && kTags.size() + i < kDicomMoments; ++i) {
      image.moment[kTags.size() + i] = indices[i];
    }
  });
  with_item(groups, Tag(0x0018, 0x9118), [&](const gdcm::DataSet& heart) {
    set(kTrigger, binary_at<double>(heart, Tag(0x0020, 0x9153)));
  });
  with_item(groups, Tag(0x0018, 0x9114), [&](const gdcm::DataSet& echo) {
    set(kEcho, binary_at<double>(echo, Tag(0x0018, 0x9082)));
  });
}

std::string order_by_moment(DicomPositions& positions) {
  Elements elements;
  for (std::size_t element = 0; element < kDicomMoments; ++element) {
    elements.push_back(element);
    if (!are_everywhere(positions, elements)) elements.pop_back();
  }
  const bool has_temporal_position = !elements.empty() && elements[0] == kTemporalPosition;
  std::map<Values, std::int64_t> least_number;
  for (const auto& images : positions) {
    for (const DicomImage& image : images) {
      const auto [found, is_new] =
          least_number.try_emplace(values_of(image, elements), image.number);
      found->second = std::min(found->second, image.number);
    }
  }
  const auto rank = [&](const DicomImage& image) {
    const Values values = values_of(image, elements);
    return std::tuple(has_temporal_position ? values[0] : 0, least_number.at(values), values,
                      image.number, image.file, image.frame);
  };
  std::string same;
  for (auto& images : positions) {
    std::sort(images.begin(), images.end(),
              [&](const DicomImage& a, const DicomImage& b) { return rank(a) < rank(b); });
    const auto alike = std::adjacent_find(
        images.begin(), images.end(), [&](const DicomImage& a, const DicomImage& b) {
          return a.number == b.number && a.moment == b.moment && a.file != b.file;
        });
    if (alike == images.end()) continue;
    same = "no number or time tells '" + alike->file.filename().string() + "' and '" +
           std::next(alike)->file.filename().string() +
           "' apart, which are at one position; they are taken in the order of their names";
  }
  return same;
}

std::optional<std::vector<DicomImage>> images_of_one_moment(const DicomPositions& positions) {
  for (std::size_t element = 0; element < kDicomMoments; ++element) {
    for (const DicomImage& wanted : positions.front()) {
      std::vector<DicomImage> chosen;
      for (const auto& images : positions) {
        const auto is_wanted = [&](const DicomImage& image) {
          return image.moment[element] == wanted.moment[element];
        };
        if (std::count_if(images.begin(), images.end(), is_wanted) != 1) break;
        chosen.push_back(*std::find_if(images.begin(), images.end(), is_wanted));
      }
      if (chosen.size() == positions.size()) return chosen;
    }
  }
  return std::nullopt;
}

std::string alternation_in(const std::vector<DicomImage>& stack) {
  for (const std::size_t element : {kTemporalPosition, kAcquisition, kEcho}) {
    std::size_t period = 1;
    while (period < stack.size() &&
           stack[period].moment[element] != stack.front().moment[element]) {
      ++period;
    }
    if (period < 2 || 2 * period > stack.size()) continue;
    bool is_periodic = true;
    for (std::size_t i = period; i < stack.size(); ++i) {
      is_periodic &= stack[i].moment[element] == stack[i - period].moment[element];
    }
    if (is_periodic) {
      return "its slices alternate between " + std::to_string(period) + " values of " +
             kNames[element] + "; they may be slices of " + std::to_string(period) + " volumes";
    }
  }
  return {};
}

}  // namespace multitetra
