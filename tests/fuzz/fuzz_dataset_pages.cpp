// A list of datasets in pages from a server that lies: the client accepts pages whose names go on
// in order, so the list ends. Each page is a message with its length in two bytes before it.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/natural_order.hpp"
#include "common/wire/messages.hpp"
#include "tests/fuzz/require.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multitetra;
  std::string_view bytes(reinterpret_cast<const char*>(data), size);
  std::vector<DatasetInfo> listed;
  std::set<std::string> requested;
  std::uint16_t length = 0;
  while (bytes.size() >= sizeof(length)) {
    std::memcpy(&length, bytes.data(), sizeof(length));
    bytes.remove_prefix(sizeof(length));
    const auto message = parse_server_message(bytes.substr(0, length));
    bytes.remove_prefix(std::min<std::size_t>(length, bytes.size()));
    const auto* const page = message ? std::get_if<DatasetList>(&*message) : nullptr;
    if (page == nullptr || !continues_list(*page, listed)) return 0;
    if (page->next.empty() && listed.empty()) return 0;  // The whole list.
    for (const DatasetInfo& info : page->datasets) {
      require(listed.empty() || natural_order_less(listed.back().name, info.name));
      listed.push_back(info);
    }
    if (page->next.empty()) return 0;
    require(page->next == listed.back().name && requested.insert(page->next).second);
  }
  return 0;
}
