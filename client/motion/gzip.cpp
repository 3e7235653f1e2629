#include "motion/gzip.h"

#include "motion/failure.h"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <new>

#define ZLIB_CONST // zlib reads bytes that are constant
#include <zlib.h>

namespace torqued
{

bool is_gzip(std::string_view bytes)
{
  return bytes.starts_with("\x1f\x8b\x08");
}

std::string unpack_gzip(std::string_view bytes, const std::string& file)
{
  z_stream stream = {};
  constexpr int gzip_only = 16 + MAX_WBITS;
  if (inflateInit2(&stream, gzip_only) != Z_OK)
    throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_stream*)> end(&stream, inflateEnd);
  const auto fail = [&](std::string_view what, std::size_t unpacked)
  {
    throw Failure(ExitCode::bad_data,
                  fmt::format("{}: {}, after {} bytes unpacked; expected a whole gzip file", file, what, unpacked));
  };

  std::string unpacked;
  std::string piece(1 << 18, '\0');
  while (is_gzip(bytes))
  {
    inflateReset(&stream);
    for (int state = Z_OK; state != Z_STREAM_END;)
    {
      const std::size_t most = std::numeric_limits<uInt>::max();
      stream.next_in = reinterpret_cast<const Bytef*>(bytes.data());
      stream.avail_in = static_cast<uInt>(std::min(bytes.size(), most));
      const std::size_t given = stream.avail_in;
      stream.next_out = reinterpret_cast<Bytef*>(piece.data());
      stream.avail_out = static_cast<uInt>(piece.size());
      state = inflate(&stream, Z_NO_FLUSH);
      bytes.remove_prefix(given - stream.avail_in);
      unpacked.append(piece, 0, piece.size() - stream.avail_out);
      if (state == Z_BUF_ERROR || (state == Z_OK && bytes.empty() && stream.avail_out > 0))
        fail("the gzip data are cut", unpacked.size());
      if (state == Z_MEM_ERROR)
        throw std::bad_alloc();
      if (state != Z_OK && state != Z_STREAM_END)
        fail(fmt::format("the gzip data are damaged ({})", stream.msg ? stream.msg : "no reason given"),
             unpacked.size());
    }
  }
  if (bytes.find_first_not_of('\0') != std::string_view::npos) // zeros may fill a block of a tape
    fail(fmt::format("{} bytes follow the gzip data", bytes.size()), unpacked.size());
  return unpacked;
}

} // namespace torqued
