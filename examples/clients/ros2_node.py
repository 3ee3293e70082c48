"""A ROS 2 node: next_pose goes out; executed_pose (the robot's) and reaction (a recogniser's) come in, as "4 low"."""

import rclpy
from face import tried
from rclpy.node import Node
from std_msgs.msg import String


class Fatplan(Node):
    """Tells the robot's node the pose of the cycle, again and again, until it says which it executes."""

    def __init__(self) -> None:
        super().__init__("fatplan")
        self.next_pose = self.create_publisher(String, "next_pose", 1)
        self.create_subscription(String, "executed_pose", self.executed, 1)
        self.create_subscription(String, "reaction", self.reaction, 1)
        self.create_timer(0.5, self.tell)

    def tell(self) -> None:
        """Say what to do; a server that does not answer is asked again."""
        if decision := tried("decide"):
            self.next_pose.publish(String(data=f"{decision['cycle']} {decision['action']}"))

    def executed(self, message: String) -> None:
        """The robot's node says what it does: that counts."""
        cycle, _, pose = message.data.partition(" ")
        if cycle.isdecimal():
            tried("executed", cycle=int(cycle), action=pose)

    def reaction(self, message: String) -> None:
        """A cycle has ended, and this was recognised."""
        cycle, _, seen = message.data.partition(" ")
        if cycle.isdecimal():
            tried("observe", cycle=int(cycle), observation=seen)


if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Fatplan())
