/// A client of torqued: publishes desired states, and gets for each of them one reply.
///
///   torqued::TorqueClient client;                                  // the bus of LCM_DEFAULT_URL
///   if (!client.wait_for_model(std::chrono::seconds(5)))
///     return "torqued does not run here";
///   torqued::desired_state_t desired = client.standing();
///   desired.q[0] = …;
///   const torqued::Reply reply = client.ask(desired, std::chrono::milliseconds(5));
///   if (const auto* command = std::get_if<torqued::torque_command_t>(&reply))
///     …                                                            // command->torque, N m
///   else
///     …                                                            // let go: there are no torques for this instant
///
/// Units, frames and signs are those of the messages (lcmtypes). Each client is a stream of its own; the daemon answers
/// one stream at a time. To be used by one thread at a time.
///
/// A client goes by one robot: the first that a daemon names. Torques for another one, as when the daemon is started
/// anew with it or two daemons share the channels, never reach the user as a command. Whoever wants to go on with the
/// other robot takes a new client.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <torqued/desired_state_t.hpp>
#include <torqued/model_info_t.hpp>
#include <torqued/rejection_t.hpp>
#include <torqued/torque_command_t.hpp>

namespace torqued
{

class LcmBus;

/// No answer came in time: a newer desired state superseded this one, a message was lost, or no daemon is there.
struct Silence
{
  std::int64_t utime; ///< of the desired state, µs
};

/// Torques came, and must not be applied: they are another robot's, not as many as the robot has, not all numbers, or
/// came before any daemon had said which robot it computes, so that none of this can be checked.
struct Discarded
{
  std::int64_t utime; ///< of the desired state, µs
  std::string detail; ///< what is wrong, in a sentence
};

/// What became of a desired state: its torques, why there are none, nothing, or torques that are none for this robot.
using Reply = std::variant<torque_command_t, rejection_t, Silence, Discarded>;

class TorqueClient
{
public:
  using Clock = std::chrono::steady_clock;

  /// Opens the bus. lcm_url: empty for LCM_DEFAULT_URL, or LCM's default; prefix: stands before each channel's name.
  /// Throws std::runtime_error, with what to do, if the bus cannot be opened or does not carry messages: at once if its
  /// URL says so already, else after the ten seconds for which LCM looks for its own message.
  explicit TorqueClient(const std::string& lcm_url = "", const std::string& prefix = "");
  ~TorqueClient();
  TorqueClient(const TorqueClient&) = delete;
  TorqueClient& operator=(const TorqueClient&) = delete;

  /// Waits until a daemon has said which robot it computes; it says so at its start and every two seconds. Throws what
  /// handle() does.
  bool wait_for_model(Clock::duration patience);
  /// The robot that was named first, by which this client goes until its end; nothing as long as none was named. Of a
  /// daemon that computes the same robot after that one, instance_id, settings_id and settings are taken over. A
  /// message that can be no robot's (numbers that are not finite, no coordinates, more joints than coordinates, names
  /// that are empty or come twice) counts as not heard.
  const std::optional<model_info_t>& model() const { return model_; }
  /// Another robot than model() that was named later, the last one: the daemon was started anew with it, or two daemons
  /// share the channels. Nothing as long as none was.
  const std::optional<model_info_t>& other_model() const { return other_model_; }

  /// A desired state of the right size, to be filled in: the robot stands still and upright on both soles, all link
  /// angles 0, base FROM_CONTACT, load_transfer and phase 0.5. Requires: model().
  ///
  /// So each foot carries half of the weight by every method that shares the load, and by the daemon's default,
  /// CONSTRAINED, as long as the posture is symmetric. In another posture CONSTRAINED loads the feet unequally, as the
  /// least torques have it; LINEAR_TRANSITION and ZMP_TRANSITION keep the halves.
  desired_state_t standing() const;

  /// Publishes a desired state and waits for what becomes of it, at the longest for `patience`; then it is silence.
  /// What comes later is dropped: torques for an instant that has passed are of no use. Stamps as publish() does.
  /// Throws what publish() and handle() do; what becomes of this desired state is then dropped.
  Reply ask(desired_state_t& desired, Clock::duration patience);

  /// Publishes a desired state without waiting. Stamps it: utime by this machine's monotonic clock, µs, but at least
  /// one more than the one before; stream_id; model_id, if the model is known. Its reply goes to on_reply().
  /// Throws std::invalid_argument if q, v and a have not num_coordinates numbers each, and nothing is published then;
  /// std::runtime_error if the bus takes no message. Whether num_coordinates is the robot's, the daemon checks.
  void publish(desired_state_t& desired);
  /// Calls back, within handle(), ask() and wait_for_model(), with one reply for each published desired state, in the
  /// order in which they come; silence `patience` after it was published. What the callback throws comes out of the
  /// call within which it ran. It may publish. handle(), ask(), wait_for_model() and on_reply() throw std::logic_error
  /// there.
  void on_reply(std::function<void(const Reply&)> callback, Clock::duration patience);
  /// Waits for messages, at the longest so long, and deals with all that are there; with 0 it does not wait.
  /// Throws std::runtime_error if the bus cannot be read any more.
  void handle(Clock::duration at_most);

  /// Readable when handle() has something to do, but for silence: for a loop of your own around poll().
  int file_descriptor();
  /// This client's, random.
  std::int64_t stream_id() const { return stream_id_; }
  /// Takes a new stream_id, because the daemon forgets neither order nor delay of a stream: for a client whose samples
  /// are STALE for good, since its clock, or its way to the daemon, is slower than when the stream began. The daemon
  /// answers OTHER_STREAM until the old one has been silent for five times its max_age. Silence is the reply to what is
  /// still outstanding.
  void restart();

private:
  void hear_model(model_info_t model);
  std::string objection(const torque_command_t& command) const;
  void require_outside_callback(const char* function) const;
  void settle(std::int64_t stream_id, std::int64_t utime, Reply reply);
  void give_up(Clock::time_point now);

  std::unique_ptr<LcmBus> bus_;
  std::string desired_channel_;
  std::vector<std::byte> buffer_; // of the desired state
  std::int64_t stream_id_;
  std::optional<model_info_t> model_, other_model_;
  std::int64_t utime_ = 0;                                // of the last desired state
  std::map<std::int64_t, Clock::time_point> outstanding_; // utime of those published, and when they become silence
  std::function<void(const Reply&)> callback_;
  Clock::duration patience_{};
  bool calling_back_ = false;
  std::int64_t asked_ = 0;     // utime that ask() waits for; 0: none
  std::optional<Reply> reply_; // to it
};

} // namespace torqued
