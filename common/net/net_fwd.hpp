// Forward declarations of Boost.Asio for headers.
#pragma once

namespace boost::asio {
class io_context;
}

namespace multitetra {
namespace asio = boost::asio;
}
