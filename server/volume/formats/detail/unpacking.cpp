#include "server/volume/formats/detail/unpacking.hpp"

#include <blosc.h>
#include <bzlib.h>
#include <lz4.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "common/base/hex_text.hpp"
#include "server/volume/formats/stored_volume.hpp"

namespace multitetra {
namespace {

constexpr std::size_t kPackedPortionBytes = std::size_t{1} << 18;

tl::unexpected<Error> damaged(const std::string& what) {
  return fail(ErrorCode::kDamagedData, what);
}

// A common interface of the streams that are unpacked forward.
class StreamUnpacker {
 public:
  enum class Progress { kContinues, kEnded, kDamaged };

  StreamUnpacker(Packing packing) : packing_(packing) { begin(); }
  ~StreamUnpacker() { end(); }
  StreamUnpacker(const StreamUnpacker&) = delete;
  StreamUnpacker& operator=(const StreamUnpacker&) = delete;

  void begin_next_member() {
    end();
    begin();
  }

  // Consumes the front of `packed` and fills the front of `into`; both shrink.
  Progress run(std::span<const std::byte>& packed, std::span<std::byte>& into) {
    if (packing_ == Packing::kHex) return run_hex(packed, into);
    constexpr std::size_t kMax = std::size_t{1} << 30;  // The libraries use 32-bit counts.
    const auto in = static_cast<unsigned>(std::min(packed.size(), kMax));
    const auto out = static_cast<unsigned>(std::min(into.size(), kMax));
    unsigned in_left = 0;
    unsigned out_left = 0;
    Progress progress = Progress::kDamaged;
    if (packing_ == Packing::kBzip2) {
      bzip2_.next_in = const_cast<char*>(reinterpret_cast<const char*>(packed.data()));
      bzip2_.avail_in = in;
      bzip2_.next_out = reinterpret_cast<char*>(into.data());
      bzip2_.avail_out = out;
      const int state = BZ2_bzDecompress(&bzip2_);
      if (state == BZ_OK) progress = Progress::kContinues;
      if (state == BZ_STREAM_END) progress = Progress::kEnded;
      in_left = bzip2_.avail_in;
      out_left = bzip2_.avail_out;
    } else {
      zlib_.next_in =
          const_cast<unsigned char*>(reinterpret_cast<const unsigned char*>(packed.data()));
      zlib_.avail_in = in;
      zlib_.next_out = reinterpret_cast<unsigned char*>(into.data());
      zlib_.avail_out = out;
      const int state = inflate(&zlib_, Z_NO_FLUSH);
      if (state == Z_OK || state == Z_BUF_ERROR) progress = Progress::kContinues;
      if (state == Z_STREAM_END) progress = Progress::kEnded;
      in_left = zlib_.avail_in;
      out_left = zlib_.avail_out;
    }
    packed = packed.subspan(in - in_left);
    into = into.subspan(out - out_left);
    return progress;
  }

 private:
  // Ends at the end of the file.
  Progress run_hex(std::span<const std::byte>& packed, std::span<std::byte>& into) {
    for (; !packed.empty() && !into.empty(); packed = packed.subspan(1)) {
      const auto letter = static_cast<char>(packed[0]);
      const auto digit = value_of_hex_digit(letter);
      if (!digit) {
        if (std::string_view(" \t\r\n").find(letter) == std::string::npos) {
          return Progress::kDamaged;
        }
        continue;
      }
      if (high_digit_) {
        into[0] = static_cast<std::byte>(*high_digit_ << 4 | *digit);
        into = into.subspan(1);
        high_digit_.reset();
      } else {
        high_digit_ = digit;
      }
    }
    return Progress::kContinues;
  }

  void begin() {
    zlib_ = {};
    bzip2_ = {};
    if (packing_ == Packing::kBzip2) {
      BZ2_bzDecompressInit(&bzip2_, 0, 0);
    } else {
      // Detects whether the frame is that of zlib or gzip.
      inflateInit2(&zlib_, packing_ == Packing::kDeflate ? -15 : 15 + 32);
    }
  }
  void end() {
    if (packing_ == Packing::kBzip2) {
      BZ2_bzDecompressEnd(&bzip2_);
    } else {
      inflateEnd(&zlib_);
    }
  }

  Packing packing_;
  z_stream zlib_{};
  bz_stream bzip2_{};
  std::optional<unsigned> high_digit_;  // The first of two hexadecimal digits.
};

bool may_have_members(Packing packing) {
  return packing == Packing::kGzip || packing == Packing::kBzip2;
}

// Returns the number of unpacked bytes; an error if there are more than into.size().
Result<std::size_t> unpack_stream(Packing packing, std::span<const std::byte> packed,
                                  std::span<std::byte> into) {
  StreamUnpacker unpacker(packing);
  const std::size_t room = into.size();
  std::array<std::byte, 1> beyond{};
  while (true) {
    const std::size_t packed_before = packed.size();
    const std::size_t into_before = into.size();
    std::span<std::byte> spare(beyond);
    const bool full = into.empty();
    const auto progress = unpacker.run(packed, full ? spare : into);
    if (spare.empty()) return damaged("it has more bytes than expected");
    if (progress == StreamUnpacker::Progress::kDamaged) return damaged("it is damaged");
    if (progress == StreamUnpacker::Progress::kEnded) {
      if (packed.empty()) return room - into.size();
      if (!may_have_members(packing)) return damaged("it has bytes after its end");
      unpacker.begin_next_member();
    } else if (packed.size() == packed_before && into.size() == into_before) {
      return damaged("it ends too early");
    }
  }
}

Result<std::size_t> unpack_zstd(std::span<const std::byte> packed, std::span<std::byte> into) {
  const std::size_t size = ZSTD_decompress(into.data(), into.size(), packed.data(), packed.size());
  if (ZSTD_isError(size) != 0) return damaged(ZSTD_getErrorName(size));
  return size;
}

Result<std::size_t> unpack_blosc(std::span<const std::byte> packed, std::span<std::byte> into) {
  std::size_t size = 0;
  if (blosc_cbuffer_validate(packed.data(), packed.size(), &size) != 0) {
    return damaged("it is not a complete Blosc buffer");
  }
  if (size > into.size()) return damaged("it has more bytes than expected");
  if (size == 0) return size;
  const int done = blosc_decompress_ctx(packed.data(), into.data(), into.size(), 1);
  if (done < 0) return damaged("it is damaged, or compressed with an unknown Blosc codec");
  return static_cast<std::size_t>(done);
}

Result<std::size_t> unpack_lz4(std::span<const std::byte> packed, std::span<std::byte> into) {
  constexpr std::size_t kMax = std::numeric_limits<int>::max();
  if (packed.size() > kMax || into.size() > kMax) return damaged("it is too large for LZ4");
  const int done = LZ4_decompress_safe(
      reinterpret_cast<const char*>(packed.data()), reinterpret_cast<char*>(into.data()),
      static_cast<int>(packed.size()), static_cast<int>(into.size()));
  if (done < 0) return damaged("it is damaged");
  return static_cast<std::size_t>(done);
}

Result<std::size_t> unpack_sized_lz4(std::span<const std::byte> packed, std::span<std::byte> into) {
  std::uint32_t size = 0;
  if (packed.size() < sizeof(size)) return damaged("it ends within its size");
  std::memcpy(&size, packed.data(), sizeof(size));  // Requires a little-endian host.
  if (size > into.size()) return damaged("it has more bytes than expected");
  const Result<std::size_t> done = unpack_lz4(packed.subspan(sizeof(size)), into.first(size));
  if (done && *done != size) return damaged("it has fewer bytes than it declares");
  return done;
}

Result<std::size_t> unpack_into(Packing packing, std::span<const std::byte> packed,
                                std::span<std::byte> into) {
  switch (packing) {
    case Packing::kNone:
      if (packed.size() > into.size()) return damaged("it has more bytes than expected");
      std::copy(packed.begin(), packed.end(), into.begin());
      return packed.size();
    case Packing::kGzip:
    case Packing::kZlib:
    case Packing::kDeflate:
    case Packing::kBzip2:
      return unpack_stream(packing, packed, into);
    case Packing::kZstd:
      return unpack_zstd(packed, into);
    case Packing::kBlosc:
      return unpack_blosc(packed, into);
    case Packing::kLz4:
      return unpack_lz4(packed, into);
    case Packing::kSizedLz4:
      return unpack_sized_lz4(packed, into);
    case Packing::kHex:
      break;
  }
  return damaged("its compression is unknown");
}

}  // namespace

std::optional<Packing> packing_from(std::string_view name) {
  if (name == "raw") return Packing::kNone;
  if (name == "gzip") return Packing::kGzip;
  if (name == "zlib") return Packing::kZlib;
  if (name == "zstd") return Packing::kZstd;
  if (name == "blosc") return Packing::kBlosc;
  if (name == "lz4") return Packing::kSizedLz4;
  if (name == "bz2" || name == "bzip2") return Packing::kBzip2;
  return std::nullopt;
}

Result<void> unpack(Packing packing, std::span<const std::byte> packed, std::span<std::byte> into) {
  const Result<std::size_t> size = unpack_into(packing, packed, into);
  if (!size) return tl::unexpected(size.error());
  if (*size == into.size()) return {};
  return damaged("it has " + std::to_string(*size) + " bytes instead of " +
                 std::to_string(into.size()));
}

Result<std::vector<std::byte>> unpack_at_most(Packing packing, std::span<const std::byte> packed,
                                              std::size_t most) {
  std::vector<std::byte> bytes(most);
  const Result<std::size_t> size = unpack_into(packing, packed, bytes);
  if (!size) return tl::unexpected(size.error());
  bytes.resize(*size);
  return bytes;
}

// ---- UnpackedStream

struct UnpackedStream::State {
  const InputFile& file;
  std::uint64_t offset;
  Packing packing;
  StreamUnpacker unpacker;
  std::vector<std::byte> portion = {};
  std::span<const std::byte> left = {};
  bool ended = false;

  // Reads the next bytes of the file; returns false at its end.
  bool refill() {
    portion.resize(kPackedPortionBytes);
    const std::size_t got = file.read_some(offset, portion);
    offset += got;
    left = std::span<const std::byte>(portion).first(got);
    return got > 0;
  }

  // Skips bytes, or those that are left if they are fewer.
  void skip(std::size_t bytes) {
    while (bytes > 0 && (!left.empty() || refill())) {
      const std::size_t some = std::min(bytes, left.size());
      left = left.subspan(some);
      bytes -= some;
    }
  }

  // Accepts padding with zeros, as on tapes; anything else indicates damage.
  void require_nothing_left() {
    do {
      const bool is_zero = std::all_of(left.begin(), left.end(),
                                       [](std::byte byte) { return byte == std::byte{0}; });
      if (is_zero) continue;
      fail_damaged(file.path(), "it has other bytes after its compressed samples");
    } while (refill());
    left = {};
  }
};

UnpackedStream::UnpackedStream(const InputFile& file, std::uint64_t offset, Packing packing)
    : state_(new State{.file = file, .offset = offset, .packing = packing, .unpacker = packing}) {}

UnpackedStream::~UnpackedStream() = default;

std::size_t UnpackedStream::read_some(std::span<std::byte> into) {
  State& state = *state_;
  const std::size_t wanted = into.size();
  while (!into.empty() && !state.ended) {
    if (state.left.empty() && !state.refill()) {
      if (state.packing == Packing::kHex) break;
      fail_incomplete(state.file.path(), "its compressed samples end too early");
    }
    switch (state.unpacker.run(state.left, into)) {
      case StreamUnpacker::Progress::kContinues:
        break;
      case StreamUnpacker::Progress::kDamaged:
        fail_damaged(state.file.path(), "its compressed samples are damaged");
      case StreamUnpacker::Progress::kEnded:
        if (state.left.empty()) state.refill();
        state.ended = !may_have_members(state.packing) || state.left.empty() ||
                      packing_at(state.file, state.offset - state.left.size()) != state.packing;
        if (state.ended) {
          // GDCM writes the checksum and the length of gzip behind bare deflated data.
          constexpr std::size_t kGzipEnd = 8;
          if (state.packing == Packing::kDeflate) state.skip(kGzipEnd);
          state.require_nothing_left();
        } else {
          state.unpacker.begin_next_member();
        }
    }
  }
  return wanted - into.size();
}

std::uint64_t UnpackedStream::require_good_end() {
  std::vector<std::byte> portion(kPackedPortionBytes);
  std::uint64_t length = 0;
  while (const std::size_t count = read_some(portion)) length += count;
  return length;
}

Packing UnpackedStream::packing_at(const InputFile& file, std::uint64_t offset) {
  std::array<std::byte, 3> first{};
  if (file.read_some(offset, first) < first.size()) return Packing::kNone;
  const auto byte = [&](std::size_t at) { return std::to_integer<int>(first[at]); };
  if (byte(0) == 0x1F && byte(1) == 0x8B) return Packing::kGzip;
  if (byte(0) == 'B' && byte(1) == 'Z' && byte(2) == 'h') return Packing::kBzip2;
  if ((byte(0) & 0x0F) == 8 && (byte(0) * 256 + byte(1)) % 31 == 0) return Packing::kZlib;
  return Packing::kNone;
}

}  // namespace multitetra
