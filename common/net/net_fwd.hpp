// Names of Boost.Asio for headers that only pass them on.
#pragma once

namespace boost::asio {
class io_context;
}

namespace multitetra {
namespace asio = boost::asio;
}
