#include "common/net/message_transport.hpp"

#include <utility>
#include <vector>

namespace multitetra {
namespace {

class Frames final : public MessageTransport {
 public:
  Frames(ByteStream& stream, const TransportOptions& options)
      : stream_(stream), frames_(options.max_message_bytes), buffer_(options.read_buffer_bytes) {}

  asio::awaitable<Result<std::string>> receive() override {
    for (;;) {
      auto content = frames_.next();
      if (!content) co_return tl::unexpected(content.error());
      if (*content) co_return **std::move(content);
      const Transfer came = co_await stream_.read_some(asio::buffer(buffer_));
      if (came.error) co_return connection_error(came.error);
      note_activity(came.bytes);
      frames_.feed({buffer_.data(), came.bytes});
    }
  }

  asio::awaitable<Result<std::size_t>> send(std::string content) override {
    const std::string header = frame_header(static_cast<std::uint32_t>(content.size()));
    const Transfer sent = co_await stream_.write(asio::buffer(header), asio::buffer(content));
    if (sent.error) co_return connection_error(sent.error);
    note_activity(0);
    co_return sent.bytes;
  }

  asio::awaitable<void> drain() override {
    Transfer came;
    while (!came.error) came = co_await stream_.read_some(asio::buffer(buffer_));
  }

  asio::awaitable<void> close_gracefully() override { co_await stream_.shut_down(); }

  void set_limit(std::uint32_t max_message_bytes) override { frames_.set_limit(max_message_bytes); }
  [[nodiscard]] bool was_cut_off() const override { return frames_.buffered() > 0; }

 private:
  ByteStream& stream_;
  FrameReader frames_;
  std::vector<char> buffer_;
};

}  // namespace

std::unique_ptr<MessageTransport> frames_over(ByteStream& stream, const TransportOptions& options) {
  return std::make_unique<Frames>(stream, options);
}

}  // namespace multitetra
