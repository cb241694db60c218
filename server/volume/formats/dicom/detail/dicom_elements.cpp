#include "server/volume/formats/dicom/detail/dicom_elements.hpp"

#include <gdcmByteValue.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace multitetra {

std::string text_at(const gdcm::DataSet& data, const gdcm::Tag& tag, std::size_t most) {
  if (!data.FindDataElement(tag)) return {};
  const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
  if (bytes == nullptr || bytes->GetLength() > most) return {};
  std::string text(bytes->GetPointer(), bytes->GetLength());
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

std::vector<double> numbers_in(std::string text, std::size_t most) {
  std::vector<double> numbers;
  std::replace(text.begin(), text.end(), '\\', ' ');
  const char* at = text.c_str();
  for (char* end = nullptr; numbers.size() < most; at = end) {
    const double number = std::strtod(at, &end);
    if (end == at || !std::isfinite(number)) break;
    numbers.push_back(number);
  }
  return numbers;
}

std::vector<double> numbers_at(const gdcm::DataSet& data, const gdcm::Tag& tag, std::size_t most) {
  return numbers_in(text_at(data, tag, 18 * most), most);
}

template <typename Number>
std::vector<Number> binary_at(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  if (!data.FindDataElement(tag)) return {};
  const gdcm::ByteValue* bytes = data.GetDataElement(tag).GetByteValue();
  if (bytes == nullptr) return {};
  std::vector<Number> numbers(bytes->GetLength() / sizeof(Number));
  if (!numbers.empty()) {
    std::memcpy(numbers.data(), bytes->GetPointer(), numbers.size() * sizeof(Number));
  }
  return numbers;
}

template std::vector<std::uint16_t> binary_at(const gdcm::DataSet&, const gdcm::Tag&);
template std::vector<std::uint32_t> binary_at(const gdcm::DataSet&, const gdcm::Tag&);
template std::vector<double> binary_at(const gdcm::DataSet&, const gdcm::Tag&);

DicomSequence sequence_at(const gdcm::DataSet& data, const gdcm::Tag& tag) {
  if (!data.FindDataElement(tag)) return nullptr;
  return data.GetDataElement(tag).GetValueAsSQ();
}

}  // namespace multitetra
