"""The mechanism in MuJoCo: discrete elastic rods, and chains of rigid segments."""
