/// The bus as the daemon hears it: messages of the channels that were asked for, and nothing else.
#pragma once

#include "wire/messages.h"

#include <cstdint>
#include <functional>
#include <string>

namespace torqued
{

/// Hands messages over one by one, in the order in which they come, each to the handler of its channel.
class Receiver
{
public:
  /// Lets nothing be thrown. The bytes live until it returns.
  using Handler = std::function<void(Bytes)>;

  virtual ~Receiver() = default;
  Receiver() = default;
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;

  /// Begins to hear a channel; what came before is not heard. The name holds no character that stands for others in a
  /// regular expression. false: the bus does not let itself be heard.
  virtual bool subscribe(const std::string& channel, Handler handler) = 0;

  /// Readable when take() has a message, unless holds().
  virtual int fd() = 0;
  /// Whether messages have been read from fd() that take() has not handed over yet.
  virtual bool holds() const = 0;
  /// Hands the next message over, without waiting for one. false: none is there.
  virtual bool take() = 0;

  /// At most so many messages of the subscribed channels found no room at this receiver and were lost since the start;
  /// −1: not known.
  virtual std::int64_t most_lost() const = 0;
};

} // namespace torqued
