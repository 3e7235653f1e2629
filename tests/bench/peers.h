/// The same inverse dynamics by other engines.
#pragma once

#include "robot/robot.h"

#include <Eigen/Core>
#include <memory>
#include <string_view>
#include <vector>

namespace torqued::bench
{

/// A robot with a floating root, told to another engine. Bars of rolling knees are links without mass there, and have
/// hinges of their own.
class Peer
{
public:
  virtual ~Peer() = default;
  virtual std::string_view name() const = 0;

  /// Takes note of a motion in the engine's own coordinates, so that only its inverse dynamics is timed below.
  /// q, v, a: length mechanism.num_q(). Returns its number.
  virtual int remember(const VectorQ& q, const VectorQ& v, const VectorQ& a) = 0;

  /// Sets the remembered motion and computes its inverse dynamics, as a user of the engine would in a loop.
  /// Of a motion that is already set, DART computes nothing but the forces again: let motions differ from call to call.
  virtual void compute(int motion) = 0;

  /// M a + C v + g of the motion computed last, in our coordinates: length mechanism.num_q().
  virtual VectorQ generalized_force() const = 0;
};

std::unique_ptr<Peer> make_mujoco(const Robot& robot);
std::unique_ptr<Peer> make_dart(const Robot& robot);
std::unique_ptr<Peer> make_kdl(const Robot& robot);

} // namespace torqued::bench
