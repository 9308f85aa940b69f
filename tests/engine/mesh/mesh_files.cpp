#include "mesh_files.h"

#include <boost/iostreams/filter/gzip.hpp>
#include <boost/iostreams/filter/zstd.hpp>
#include <boost/iostreams/filtering_streambuf.hpp>

namespace plait::mesh_files {
namespace {

template <class Compressor>
std::string compress(const Compressor& compressor, const std::string& bytes) {
  namespace io = boost::iostreams;
  std::ostringstream result;
  io::filtering_streambuf<io::output> stream;
  stream.push(compressor);
  stream.push(result);
  stream.sputn(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  io::close(stream);
  return result.str();
}

}  // namespace

std::string gzip(const std::string& bytes) {
  return compress(boost::iostreams::gzip_compressor(), bytes);
}

std::string zstd(const std::string& bytes) {
  return compress(boost::iostreams::zstd_compressor(), bytes);
}

}  // namespace plait::mesh_files
