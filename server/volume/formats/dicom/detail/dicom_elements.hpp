// Elements of DICOM data sets as text and numbers.
#pragma once

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmTag.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace multitetra {

using DicomSequence = gdcm::SmartPointer<gdcm::SequenceOfItems>;

// Returns the text without padding; empty if it is absent or longer than `most` bytes.
[[nodiscard]] std::string text_at(const gdcm::DataSet& data, const gdcm::Tag& tag,
                                  std::size_t most = 1024);

// Returns the finite values of a text element, which backslashes separate.
[[nodiscard]] std::vector<double> numbers_in(std::string text, std::size_t most = 64);
[[nodiscard]] std::vector<double> numbers_at(const gdcm::DataSet& data, const gdcm::Tag& tag,
                                             std::size_t most = 64);

// Returns the little-endian values of a binary element of unsigned integers of 16 or 32 bits, or of
// doubles.
template <typename Number>
[[nodiscard]] std::vector<Number> binary_at(const gdcm::DataSet& data, const gdcm::Tag& tag);

// Returns null if it is absent.
[[nodiscard]] DicomSequence sequence_at(const gdcm::DataSet& data, const gdcm::Tag& tag);

// Calls use(data set) for the first item of a sequence, if there is one.
template <typename Use>
void with_item(const gdcm::DataSet& data, const gdcm::Tag& tag, const Use& use) {
  const DicomSequence sequence = sequence_at(data, tag);
  if (sequence != nullptr && sequence->GetNumberOfItems() > 0) {
    use(sequence->GetItem(1).GetNestedDataSet());
  }
}

}  // namespace multitetra
