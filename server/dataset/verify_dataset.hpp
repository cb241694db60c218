// Verifies every byte of a prepared dataset, for example after copying or on a suspect disk.
//
//   verify_dataset("head.mtd", [](double fraction) { std::cout << 100 * fraction << " %\n"; });
//
// Guaranteed: any file that differs in a byte from one that our writer finished is reported, with
// the section and, in the large sections, the brick. Besides the checksums, the range and the
// number of void samples in the metadata must match the samples. Reads the file once, from front to
// back except for the small sections; holds only those, one brick and the indexes in memory. Uses
// no memory mapping, so a failing disk is reported as an error too.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "common/base/result.hpp"
#include "server/dataset/byte_source.hpp"

namespace multitetra {

// Called from time to time with the verified fraction of the bytes, 0 to 1 and never decreasing. An
// exception it throws ends the verification.
using VerificationProgress = std::function<void(double fraction)>;

// Verifies a file or an address and returns its size. Throws StoreError, or a DatasetFileError that
// names the file, the section, the brick and the remedy.
std::uint64_t verify_dataset(const std::string& place, const VerificationProgress& progress = {});

// Verifies any source of bytes and returns the first damage found. Throws what the source and
// `progress` throw.
[[nodiscard]] Result<void> verify_bytes(const ByteSource& source,
                                        const VerificationProgress& progress = {});

}  // namespace multitetra
