// Verifies every byte of a prepared dataset: after copying, or when a disk is doubted.
//
//   verify_dataset("head.mtd", [](double fraction) { std::cout << 100 * fraction << " %\n"; });
//
// Guaranteed: any file that differs in a byte from one that our writer finished is reported, with
// the section and, in the large sections, the brick. Beyond the checksums, the facts in the
// metadata (range, void samples) must be those of the samples. Reads the file once, from front to
// back but for the small sections, and needs memory for them, a brick and the indexes only. Nothing
// is mapped: a disk that fails gives an error too.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/base/result.hpp"
#include "server/dataset/byte_source.hpp"

namespace multitetra {

// Called from time to time with the fraction of the bytes that is done, from 0 to 1 and never
// decreasing. An exception that it throws ends the verification.
using VerificationProgress = std::function<void(double fraction)>;

// A file or an address. Throws DatasetFileError, which names the file, the section, the brick and
// what to do, and StoreError. Returns the size of the file.
std::uint64_t verify_dataset(const std::string& place, const VerificationProgress& progress = {});

// The same for bytes from anywhere: the first damage found, or nothing. Throws what the source and
// `progress` throw.
[[nodiscard]] Result<void> verify_bytes(const ByteSource& source,
                                        const VerificationProgress& progress = {});

}  // namespace multitetra
